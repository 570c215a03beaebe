#include "app.h"

int main(void) {
    (void)app_start(); // if it fails, app_poll() only reports that over the serial port
    for (;;) {
        app_poll();
    }
}
