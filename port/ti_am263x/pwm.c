// The counters run up and down. The high sides are on around the upper turning point, so all low sides
// are on around zero: there the shunts carry the phase currents, the compare values are loaded and the ADCs are
// triggered. That instant is t_k. With double update loading and triggering also happen at the upper one.
#include "chip.h"
#include "figures.h"

#define TRIP_SOURCES (TZ_DCAEVT1 | TZ_DCBEVT1 | TZ_OST5 | TZ_OST6)
#define TRIP_LATCHES (TZOST_DCAEVT1 | TZOST_DCBEVT1 | TZOST_OST5 | TZOST_OST6)

static const uint32_t pwm[CHIP_PHASES] = VARIANT_PWM;
static uint16_t steps;
static uint16_t written[CHIP_PHASES]; // compare values

#define LOADED (VARIANT_DOUBLE_UPDATE ? CMPCTL_AT_ZERO_AND_PERIOD : CMPCTL_AT_ZERO)
#define TRIGGERED (VARIANT_DOUBLE_UPDATE ? ETSEL_SOCA_AT_ZERO_AND_PERIOD : ETSEL_SOCA_AT_ZERO)

static void time_base(uint32_t base) {
    // A halt must not stop the counter, which would hold the present switch states; instead it trips.
    reg_write16(base + EPWM_TBCTL, TBCTL_UP_DOWN | TBCTL_PERIOD_AT_ONCE | TBCTL_FREE_RUN);
    reg_write16(base + EPWM_TBPRD, steps);
    reg_write16(base + EPWM_TBCTR, 0u);
    reg_write16(base + EPWM_CMPCTL, LOADED); // shadow
    reg_write16(base + EPWM_AQCTLA, AQCTL_HIGH_AT_CMPA_UP | AQCTL_LOW_AT_CMPA_DOWN);
    // Has no effect after the dead-band unit, which derives output B from A, except when only the low sides switch.
    reg_write16(base + EPWM_AQCTLB, AQCTL_LOW_AT_CMPA_UP | AQCTL_HIGH_AT_CMPA_DOWN);
    reg_write16(base + EPWM_AQSFRC, AQSFRC_AT_ONCE);
    reg_write16(base + EPWM_AQCSFRC, 0u);
}

// Output A is input A with its rising edge delayed, output B its complement with the other edge delayed.
static void dead_band(uint32_t base, uint16_t counts) {
    reg_write16(base + EPWM_DBRED, counts);
    reg_write16(base + EPWM_DBFED, counts);
    reg_write16(base + EPWM_DBCTL, DBCTL_BOTH_EDGES | DBCTL_COMPLEMENT);
}

// One-shot, both outputs low: comparators (TRIPIN1 high), fault line (TRIPIN2 low), lost clock, halted
// core. Asynchronous, so that they act without a clock. Locked until the next reset.
static void trip_zone(uint32_t base) {
    reg_write16(base + EPWM_TZCTL, TZCTL_A_LOW | TZCTL_B_LOW);
    reg_write16(base + EPWM_DCTRIPSEL, DCTRIPSEL_AH_1_BH_2);
    reg_write16(base + EPWM_DCACTL, DCCTL_EVT1_ASYNC);
    reg_write16(base + EPWM_DCBCTL, DCCTL_EVT1_ASYNC);
    reg_write16(base + EPWM_TZDCSEL, TZDCSEL_A1_HIGH | TZDCSEL_B1_LOW);
    reg_write16(base + EPWM_TZSEL, TRIP_SOURCES);
    reg_write32(base + EPWM_LOCK, LOCK_TRIP_ZONE_AND_COMPARE);
}

static void controlss_unlock(void) {
    reg_write32(CONTROLSS_KICK0, KICK0_UNLOCK);
    reg_write32(CONTROLSS_KICK1, KICK1_UNLOCK);
}

static void clock_sync(bool on) {
    uint32_t bits = 0u;
    for (uint32_t n = 0u; n < CHIP_PHASES; n++) {
        bits |= 1u << pwm[n];
    }
    const uint32_t others = reg_read32(CONTROLSS_CLKSYNC) & ~bits;
    controlss_unlock();
    reg_write32(CONTROLSS_CLKSYNC, on ? others | bits : others);
}

// Without it the bridge would keep switching at the last duties after a breakpoint: the counters run free, and
// TZ6 does not respond.
static void halt_reaches(uint32_t n) {
    controlss_unlock();
    reg_write32(CONTROLSS_EPWM_HALTEN(n), HALTEN_R5SS0_CORE0);
}

bool chip_pwm_init(void) {
    uint16_t dead_counts = 0u;
    steps = (uint16_t)port_pwm_steps(CHIP_F_PWM_Hz, VARIANT_F_PWM_Hz);
    if (steps == 0u || !ti_dead_time(CHIP_F_PWM_Hz, VARIANT_DEAD_TIME_ns, &dead_counts)) {
        return false;
    }
    clock_sync(false);
    chip_pwm_off(); // before any other register of them is written
    bool answers = true;
    for (uint32_t n = 0u; n < CHIP_PHASES; n++) {
        time_base(EPWM(pwm[n]));
        dead_band(EPWM(pwm[n]), dead_counts);
        trip_zone(EPWM(pwm[n]));
        halt_reaches(pwm[n]);
        answers = answers && reg_read16(EPWM(pwm[n]) + EPWM_TBPRD) == steps &&
                  reg_read16(EPWM(pwm[n]) + EPWM_DBRED) == dead_counts &&
                  reg_read16(EPWM(pwm[n]) + EPWM_TZSEL) == TRIP_SOURCES &&
                  (reg_read16(EPWM(pwm[n]) + EPWM_TZFLG) & TZFLG_OST) != 0u &&
                  reg_read32(CONTROLSS_EPWM_HALTEN(pwm[n])) == HALTEN_R5SS0_CORE0;
    }
    chip_pwm_write((lode_abc_t){0.5f, 0.5f, 0.5f}); // no voltage between the phases
    reg_write16(EPWM(pwm[0]) + EPWM_ETPS, ETPS_SOCA_EVERY);
    reg_write16(EPWM(pwm[0]) + EPWM_ETSEL, TRIGGERED);
    return answers;
}

void chip_pwm_start(void) {
    clock_sync(true);
}

// Bypasses the dead-band, and forces A low at once, whatever its state.
void chip_pwm_low_sides_alone(bool alone) {
    for (uint32_t n = 0u; n < CHIP_PHASES; n++) {
        reg_write16(EPWM(pwm[n]) + EPWM_AQCSFRC, alone ? AQCSFRC_A_LOW : 0u);
        reg_write16(EPWM(pwm[n]) + EPWM_DBCTL, alone ? 0u : DBCTL_BOTH_EDGES | DBCTL_COMPLEMENT);
    }
}

LODE_RAMFUNC void chip_pwm_off(void) {
    reg_write16(EPWM(pwm[0]) + EPWM_TZFRC, TZFRC_OST);
    reg_write16(EPWM(pwm[1]) + EPWM_TZFRC, TZFRC_OST);
    reg_write16(EPWM(pwm[2]) + EPWM_TZFRC, TZFRC_OST);
}

// Latches of the trip sources; a trip forced by software does not set them.
LODE_RAMFUNC bool chip_pwm_tripped(void) {
    const uint32_t latched = (uint32_t)reg_read16(EPWM(pwm[0]) + EPWM_TZOSTFLG) |
                             (uint32_t)reg_read16(EPWM(pwm[1]) + EPWM_TZOSTFLG) |
                             (uint32_t)reg_read16(EPWM(pwm[2]) + EPWM_TZOSTFLG);
    return (latched & TRIP_LATCHES) != 0u;
}

LODE_RAMFUNC void chip_pwm_on(void) {
    if (chip_pwm_tripped()) {
        return;
    }
    for (uint32_t n = 0u; n < CHIP_PHASES; n++) {
        if ((reg_read16(EPWM(pwm[n]) + EPWM_TZFLG) & TZFLG_OST) != 0u) {
            reg_write16(EPWM(pwm[n]) + EPWM_TZCLR, TZFLG_OST | TZFLG_DCAEVT1 | TZFLG_DCBEVT1);
        }
    }
    if (chip_pwm_tripped()) { // a trip came in between, and was too short to trip again
        chip_pwm_off();
    }
}

void chip_pwm_clear_trip(void) {
    for (uint32_t n = 0u; n < CHIP_PHASES; n++) {
        reg_write16(EPWM(pwm[n]) + EPWM_TZOSTCLR, TRIP_LATCHES);
    }
}

LODE_RAMFUNC bool chip_pwm_counts_down(void) {
    return (reg_read16(EPWM(pwm[0]) + EPWM_TBSTS) & TBSTS_UP) == 0u;
}

LODE_RAMFUNC void chip_pwm_write(lode_abc_t duty) {
    written[0] = ti_compare(duty.a, steps, VARIANT_DOUBLE_UPDATE);
    written[1] = ti_compare(duty.b, steps, VARIANT_DOUBLE_UPDATE);
    written[2] = ti_compare(duty.c, steps, VARIANT_DOUBLE_UPDATE);
    reg_write16(EPWM(pwm[0]) + EPWM_CMPA, written[0]);
    reg_write16(EPWM(pwm[1]) + EPWM_CMPA, written[1]);
    reg_write16(EPWM(pwm[2]) + EPWM_CMPA, written[2]);
}

LODE_RAMFUNC bool chip_pwm_holds(void) {
    return reg_read16(EPWM(pwm[0]) + EPWM_CMPA) == written[0] &&
           reg_read16(EPWM(pwm[1]) + EPWM_CMPA) == written[1] &&
           reg_read16(EPWM(pwm[2]) + EPWM_CMPA) == written[2];
}
