#include "app.h"

int main(void) {
    (void)
        app_start(); // where it fails, app_poll() says so over the serial port, and does nothing else
    for (;;) {
        app_poll();
    }
}
