// The counters run up and down. The high sides are on around the upper turning point, so all low sides
// are on around zero: there the shunts carry the phase currents, the compare values are loaded and the ADCs are
// triggered. That instant is t_k. With double update loading and triggering also happen at the upper one.
#include "chip.h"
#include "figures.h"

#define TRIP_SOURCES                                                                               \
    (EPWM_TZ_SIGNAL_DCAEVT1 | EPWM_TZ_SIGNAL_OSHT1 | EPWM_TZ_SIGNAL_OSHT5 | EPWM_TZ_SIGNAL_OSHT6)
#define TRIP_LATCHES                                                                               \
    (EPWM_TZ_OST_FLAG_DCAEVT1 | EPWM_TZ_OST_FLAG_OST1 | EPWM_TZ_OST_FLAG_OST5 |                    \
     EPWM_TZ_OST_FLAG_OST6)

static const uint32_t pwm[CHIP_PHASES] = VARIANT_PWM;
static uint16_t steps;
static uint16_t written[CHIP_PHASES]; // compare values

#define LOADED                                                                                     \
    (VARIANT_DOUBLE_UPDATE ? EPWM_COMP_LOAD_ON_CNTR_ZERO_PERIOD : EPWM_COMP_LOAD_ON_CNTR_ZERO)
#define TRIGGERED (VARIANT_DOUBLE_UPDATE ? EPWM_SOC_TBCTR_ZERO_OR_PERIOD : EPWM_SOC_TBCTR_ZERO)

static void time_base(uint32_t base) {
    EPWM_setClockPrescaler(base, EPWM_CLOCK_DIVIDER_1, EPWM_HSCLOCK_DIVIDER_1);
    EPWM_setEmulationMode(base, EPWM_EMULATION_FREE_RUN); // a halt trips, see trip_zone()
    EPWM_disablePhaseShiftLoad(base);
    EPWM_setTimeBasePeriod(base, steps);
    EPWM_setTimeBaseCounter(base, 0u);
    EPWM_setTimeBaseCounterMode(base, EPWM_COUNTER_MODE_UP_DOWN);
    EPWM_setCounterCompareShadowLoadMode(base, EPWM_COUNTER_COMPARE_A, LOADED);
    EPWM_setActionQualifierAction(base, EPWM_AQ_OUTPUT_A, EPWM_AQ_OUTPUT_HIGH,
                                  EPWM_AQ_OUTPUT_ON_TIMEBASE_UP_CMPA);
    EPWM_setActionQualifierAction(base, EPWM_AQ_OUTPUT_A, EPWM_AQ_OUTPUT_LOW,
                                  EPWM_AQ_OUTPUT_ON_TIMEBASE_DOWN_CMPA);
    // Has no effect after the dead-band unit, which derives output B from A, except when only the low sides switch.
    EPWM_setActionQualifierAction(base, EPWM_AQ_OUTPUT_B, EPWM_AQ_OUTPUT_LOW,
                                  EPWM_AQ_OUTPUT_ON_TIMEBASE_UP_CMPA);
    EPWM_setActionQualifierAction(base, EPWM_AQ_OUTPUT_B, EPWM_AQ_OUTPUT_HIGH,
                                  EPWM_AQ_OUTPUT_ON_TIMEBASE_DOWN_CMPA);
    EPWM_setActionQualifierContSWForceShadowMode(base, EPWM_AQ_SW_IMMEDIATE_LOAD);
    EPWM_setActionQualifierContSWForceAction(base, EPWM_AQ_OUTPUT_A, EPWM_AQ_SW_DISABLED);
}

// Output A is input A with its rising edge delayed, output B its complement with the other edge delayed.
static void dead_band(uint32_t base, uint16_t counts) {
    EPWM_setDeadBandCounterClock(base, EPWM_DB_COUNTER_CLOCK_FULL_CYCLE);
    EPWM_setRisingEdgeDeadBandDelayInput(base, EPWM_DB_INPUT_EPWMA);
    EPWM_setFallingEdgeDeadBandDelayInput(base, EPWM_DB_INPUT_EPWMA);
    EPWM_setDeadBandDelayPolarity(base, EPWM_DB_RED, EPWM_DB_POLARITY_ACTIVE_HIGH);
    EPWM_setDeadBandDelayPolarity(base, EPWM_DB_FED, EPWM_DB_POLARITY_ACTIVE_LOW);
    EPWM_setRisingEdgeDelayCount(base, counts);
    EPWM_setFallingEdgeDelayCount(base, counts);
    EPWM_setDeadBandDelayMode(base, EPWM_DB_RED, true);
    EPWM_setDeadBandDelayMode(base, EPWM_DB_FED, true);
}

// One-shot, both outputs low: comparators (TRIP4), nFAULT (TZ1), lost clock (TZ5), halted core (TZ6).
// Asynchronous, so that they act without a clock. Locked until the next reset.
static void trip_zone(uint32_t base) {
    EPWM_setTripZoneAction(base, EPWM_TZ_ACTION_EVENT_TZA, EPWM_TZ_ACTION_LOW);
    EPWM_setTripZoneAction(base, EPWM_TZ_ACTION_EVENT_TZB, EPWM_TZ_ACTION_LOW);
    EPWM_selectDigitalCompareTripInput(base, EPWM_DC_TRIP_TRIPIN4, EPWM_DC_TYPE_DCAH);
    EPWM_setTripZoneDigitalCompareEventCondition(base, EPWM_TZ_DC_OUTPUT_A1,
                                                 EPWM_TZ_EVENT_DCXH_HIGH);
    EPWM_setDigitalCompareEventSource(base, EPWM_DC_MODULE_A, EPWM_DC_EVENT_1,
                                      EPWM_DC_EVENT_SOURCE_ORIG_SIGNAL);
    EPWM_setDigitalCompareEventSyncMode(base, EPWM_DC_MODULE_A, EPWM_DC_EVENT_1,
                                        EPWM_DC_EVENT_INPUT_NOT_SYNCED);
    EPWM_enableTripZoneSignals(base, TRIP_SOURCES);
    EPWM_lockRegisters(base, EPWM_REGISTER_GROUP_TRIP_ZONE);
    EPWM_lockRegisters(base, EPWM_REGISTER_GROUP_DIGITAL_COMPARE);
}

bool chip_pwm_init(void) {
    static const SysCtl_PeripheralPCLOCKCR clocks[CHIP_PHASES] = VARIANT_PWM_CLOCKS;
    uint16_t dead_counts = 0u;
    steps = (uint16_t)port_pwm_steps(CHIP_F_PWM_Hz, VARIANT_F_PWM_Hz);
    if (steps == 0u || !ti_dead_time(CHIP_F_CPU_Hz, VARIANT_DEAD_TIME_ns, &dead_counts)) {
        return false;
    }
    SysCtl_disablePeripheral(SYSCTL_PERIPH_CLK_TBCLKSYNC);
    for (uint32_t n = 0u; n < CHIP_PHASES; n++) {
        SysCtl_enablePeripheral(clocks[n]);
    }
    chip_pwm_off(); // before any other register of them is written
    for (uint32_t n = 0u; n < CHIP_PHASES; n++) {
        time_base(pwm[n]);
        dead_band(pwm[n], dead_counts);
        trip_zone(pwm[n]);
    }
    chip_pwm_write((lode_abc_t){0.5f, 0.5f, 0.5f}); // no voltage between the phases
    EPWM_setADCTriggerSource(pwm[0], EPWM_SOC_A, TRIGGERED);
    EPWM_setADCTriggerEventPrescale(pwm[0], EPWM_SOC_A, 1u);
    EPWM_enableADCTrigger(pwm[0], EPWM_SOC_A);
    return true;
}

void chip_pwm_start(void) {
    SysCtl_enablePeripheral(SYSCTL_PERIPH_CLK_TBCLKSYNC);
}

// Bypasses the dead-band, and forces A low at once, whatever its state.
void chip_pwm_low_sides_alone(bool alone) {
    for (uint32_t n = 0u; n < CHIP_PHASES; n++) {
        EPWM_setActionQualifierContSWForceAction(
            pwm[n], EPWM_AQ_OUTPUT_A, alone ? EPWM_AQ_SW_OUTPUT_LOW : EPWM_AQ_SW_DISABLED);
        EPWM_setDeadBandDelayMode(pwm[n], EPWM_DB_RED, !alone);
        EPWM_setDeadBandDelayMode(pwm[n], EPWM_DB_FED, !alone);
    }
}

LODE_RAMFUNC void chip_pwm_off(void) {
    EPWM_forceTripZoneEvent(pwm[0], EPWM_TZ_FORCE_EVENT_OST);
    EPWM_forceTripZoneEvent(pwm[1], EPWM_TZ_FORCE_EVENT_OST);
    EPWM_forceTripZoneEvent(pwm[2], EPWM_TZ_FORCE_EVENT_OST);
}

// Latches of the trip sources; a trip forced by software does not set them.
LODE_RAMFUNC bool chip_pwm_tripped(void) {
    const uint16_t latched = (uint16_t)(EPWM_getOneShotTripZoneFlagStatus(pwm[0]) |
                                        EPWM_getOneShotTripZoneFlagStatus(pwm[1]) |
                                        EPWM_getOneShotTripZoneFlagStatus(pwm[2]));
    return (latched & TRIP_LATCHES) != 0u;
}

LODE_RAMFUNC void chip_pwm_on(void) {
    if (chip_pwm_tripped()) {
        return;
    }
    for (uint32_t n = 0u; n < CHIP_PHASES; n++) {
        if ((EPWM_getTripZoneFlagStatus(pwm[n]) & EPWM_TZ_FLAG_OST) != 0u) {
            EPWM_clearTripZoneFlag(pwm[n], EPWM_TZ_FLAG_OST | EPWM_TZ_FLAG_DCAEVT1);
        }
    }
    if (chip_pwm_tripped()) { // a trip came in between, and was too short to trip again
        chip_pwm_off();
    }
}

void chip_pwm_clear_trip(void) {
    for (uint32_t n = 0u; n < CHIP_PHASES; n++) {
        EPWM_clearOneShotTripZoneFlag(pwm[n], TRIP_LATCHES);
    }
}

LODE_RAMFUNC bool chip_pwm_counts_down(void) {
    return EPWM_getTimeBaseCounterDirection(pwm[0]) == EPWM_TIME_BASE_STATUS_COUNT_DOWN;
}

LODE_RAMFUNC void chip_pwm_write(lode_abc_t duty) {
    written[0] = ti_compare(duty.a, steps, VARIANT_DOUBLE_UPDATE);
    written[1] = ti_compare(duty.b, steps, VARIANT_DOUBLE_UPDATE);
    written[2] = ti_compare(duty.c, steps, VARIANT_DOUBLE_UPDATE);
    EPWM_setCounterCompareValue(pwm[0], EPWM_COUNTER_COMPARE_A, written[0]);
    EPWM_setCounterCompareValue(pwm[1], EPWM_COUNTER_COMPARE_A, written[1]);
    EPWM_setCounterCompareValue(pwm[2], EPWM_COUNTER_COMPARE_A, written[2]);
}

LODE_RAMFUNC bool chip_pwm_holds(void) {
    return EPWM_getCounterCompareValue(pwm[0], EPWM_COUNTER_COMPARE_A) == written[0] &&
           EPWM_getCounterCompareValue(pwm[1], EPWM_COUNTER_COMPARE_A) == written[1] &&
           EPWM_getCounterCompareValue(pwm[2], EPWM_COUNTER_COMPARE_A) == written[2];
}
