/// Runs the example application on the simulated plant until the judge is finished.
#include "app.h"
#include "emulator.h"
#include "judge.h"
#include "machine.h"
#include "semihost.h"

int main(void) {
    if (semihost_has_argument("overlong")) {
        emulator_overlong();
    }
    if (!app_start()) {
        semihost_print("FAIL refused: ");
        semihost_print(lode_status_name(app_status()));
        semihost_print("\n");
        return 1;
    }
    app_armed = 1u;
    while (!judge_done()) {
        app_poll();
        machine_wait();
    }
    return judge_verdict() ? 0 : 1;
}
