#include "app.h"

int main(void) {
    const bool started = app_start();
    for (;;) {
        if (started) { // else app_status() says which field is wrong; LODE_OK: the board did not come up
            app_poll();
        }
    }
}
