/// Before the C environment is up. TI's own start-up code does the rest.
#include "driverlib.h"
#include "lodestar/platform.h"

#if defined(__TMS320C28XX__)
// Of f28004x.cmd.
extern uint16_t RamfuncsLoadStart[], RamfuncsLoadSize[], RamfuncsRunStart[];

int _system_pre_init(void);

/// Copies .TI.ramfunc. Device_init() does so too, but the configuration is computed before it and
/// uses functions of the interrupt. Its time must not be the watchdog's.
int _system_pre_init(void) {
    SysCtl_disableWatchdog();
    for (uint32_t n = 0u; n < (uint32_t)RamfuncsLoadSize; n++) {
        RamfuncsRunStart[n] = RamfuncsLoadStart[n];
    }
    return 1; // initialise the variables
}

/// LODE_SIGNAL_FENCE(): what the compiler cannot see into, it cannot move memory accesses across.
void lode_fence(void) {}
#endif
