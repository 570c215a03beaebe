#include "app.h"

int main(void) {
    const bool started = app_start();
    while (started) {
        app_poll();
    }
    for (;;) { // app_status() says which field is wrong; LODE_OK: the board did not come up
    }
}
