/// Runs before the C environment is set up. TI's own start-up code does the rest.
#include "driverlib.h"
#include "lodestar/platform.h"

#if defined(__TMS320C28XX__)
// Symbols of f28004x.cmd.
extern uint16_t RamfuncsLoadStart[], RamfuncsLoadSize[], RamfuncsRunStart[];

int _system_pre_init(void);

/// Copies .TI.ramfunc. Device_init() does so too, but the configuration is computed before it and uses
/// functions of the interrupt. The watchdog must not expire meanwhile.
int _system_pre_init(void) {
    SysCtl_disableWatchdog();
    for (uint32_t n = 0u; n < (uint32_t)RamfuncsLoadSize; n++) {
        RamfuncsRunStart[n] = RamfuncsLoadStart[n];
    }
    return 1; // initialise the variables
}

/// LODE_SIGNAL_FENCE(): the compiler cannot move memory accesses across a function that it cannot see into.
void lode_fence(void) {}
#endif
