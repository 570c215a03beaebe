#include "f28004x.h"

#include <string.h>

#include "device.h"

#define ENTRIES_MAX 65536
#define ARGUMENTS 5
#define PHASES 3
#define RESULTS 2
#define HANDLERS 8
#define TEXT_MAX 4096
#define NO_CURRENT_COUNT 2048u

typedef struct {
    const char *name;
    uint32_t argument[ARGUMENTS];
} entry_t;

typedef struct {
    uint16_t flags;   // TZFLG
    uint16_t latches; // TZOSTFLG
} zone_t;

static const uint32_t pwm[PHASES] = {EPWM6_BASE, EPWM5_BASE, EPWM3_BASE};
static const uint32_t pins[2 * PHASES] = {GPIO_10_EPWM6_A, GPIO_11_EPWM6_B, GPIO_8_EPWM5_A,
                                          GPIO_9_EPWM5_B,  GPIO_4_EPWM3_A,  GPIO_5_EPWM3_B};

static struct {
    entry_t entries[ENTRIES_MAX];
    int count;
    zone_t zone[PHASES];
    bool comparator[PHASES], dead_high[PHASES], dead_low[PHASES], fault, clock_lost, halted, dead,
        overflow;
    uint16_t direction;
    uint32_t cycles;
    uint16_t result[PHASES][RESULTS];
    uint32_t handler_number[HANDLERS];
    fake_handler_t handler[HANDLERS];
    uint32_t room, causes;
    char text[TEXT_MAX];
    size_t text_length;
} fake;

static const uint32_t cmpss[PHASES] = {CMPSS5_BASE, CMPSS3_BASE, CMPSS1_BASE};
static const XBAR_EPWMMuxConfig way[PHASES] = {XBAR_EPWM_MUX08_CMPSS5_CTRIPH_OR_L,
                                               XBAR_EPWM_MUX04_CMPSS3_CTRIPH_OR_L,
                                               XBAR_EPWM_MUX00_CMPSS1_CTRIPH_OR_L};
static const uint32_t way_bit[PHASES] = {XBAR_MUX08, XBAR_MUX04, XBAR_MUX00};

void fake_reset(void) {
    memset(&fake, 0, sizeof fake);
    fake.direction = EPWM_TIME_BASE_STATUS_COUNT_UP;
    fake.room = TEXT_MAX;
}

static void call(const char *name, const uint32_t argument[ARGUMENTS]) {
    if (fake.count < ENTRIES_MAX) {
        entry_t *entry = &fake.entries[fake.count++];
        entry->name = name;
        memcpy(entry->argument, argument, sizeof entry->argument);
    }
}

int fake_count(void) {
    return fake.count;
}

static bool matches(int index, const char *name, const uint32_t wanted[3]) {
    if (strcmp(fake.entries[index].name, name) != 0) {
        return false;
    }
    for (int n = 0; n < 3; n++) {
        if (wanted[n] != FAKE_ANY && wanted[n] != fake.entries[index].argument[n]) {
            return false;
        }
    }
    return true;
}

int fake_first(const char *name, uint32_t a, uint32_t b, uint32_t c, int from) {
    for (int n = from; n >= 0 && n < fake.count; n++) {
        if (matches(n, name, (uint32_t[]){a, b, c})) {
            return n;
        }
    }
    return -1;
}

int fake_last(const char *name, uint32_t a, uint32_t b, uint32_t c) {
    int n = fake.count - 1;
    while (n >= 0 && !matches(n, name, (uint32_t[]){a, b, c})) {
        n--;
    }
    return n;
}

const uint32_t *fake_arguments(int index) {
    return fake.entries[index].argument;
}

// --- trip zones ---

static bool called(const char *name, uint32_t a, uint32_t b, uint32_t c) {
    return fake_first(name, a, b, c, 0) >= 0;
}

static bool signal_enabled(uint32_t base, uint16_t signal) {
    const int at = fake_last("EPWM_enableTripZoneSignals", base, FAKE_ANY, FAKE_ANY);
    return at >= 0 && (fake_arguments(at)[1] & signal) != 0;
}

// Its output is high: set by the test, or a threshold lies beyond the signal of no current.
static bool compared(int n) {
    const int high = fake_last("CMPSS_setDACValueHigh", cmpss[n], FAKE_ANY, FAKE_ANY);
    const int low = fake_last("CMPSS_setDACValueLow", cmpss[n], FAKE_ANY, FAKE_ANY);
    const bool beyond = high >= 0 && low >= 0 &&
                        ((fake_arguments(high)[1] < NO_CURRENT_COUNT && !fake.dead_high[n]) ||
                         (fake_arguments(low)[1] > NO_CURRENT_COUNT && !fake.dead_low[n]));
    return fake.comparator[n] || beyond;
}

static bool comparator_reaches(int n, uint32_t base) {
    return called("CMPSS_enableModule", cmpss[n], FAKE_ANY, FAKE_ANY) &&
           called("CMPSS_configOutputsHigh", cmpss[n], CMPSS_TRIP_FILTER | CMPSS_TRIPOUT_FILTER,
                  FAKE_ANY) &&
           called("CMPSS_configOutputsLow", cmpss[n], CMPSS_TRIP_FILTER | CMPSS_TRIPOUT_FILTER,
                  FAKE_ANY) &&
           called("XBAR_setEPWMMuxConfig", XBAR_TRIP4, way[n], FAKE_ANY) &&
           called("XBAR_enableEPWMMux", XBAR_TRIP4, way_bit[n], FAKE_ANY) &&
           called("EPWM_selectDigitalCompareTripInput", base, EPWM_DC_TRIP_TRIPIN4,
                  EPWM_DC_TYPE_DCAH) &&
           called("EPWM_setTripZoneDigitalCompareEventCondition", base, EPWM_TZ_DC_OUTPUT_A1,
                  EPWM_TZ_EVENT_DCXH_HIGH) &&
           signal_enabled(base, EPWM_TZ_SIGNAL_DCAEVT1);
}

static bool fault_reaches(uint32_t base) {
    return called("XBAR_setInputPin", XBAR_INPUT1, 40u, FAKE_ANY) &&
           signal_enabled(base, EPWM_TZ_SIGNAL_OSHT1);
}

static void act(zone_t *zone, bool comes, uint16_t latch, uint16_t flags) {
    if (comes) {
        zone->latches |= latch;
        zone->flags |= EPWM_TZ_FLAG_OST | flags;
    }
}

static void sources_act(void) {
    for (int n = 0; n < PHASES; n++) {
        for (int c = 0; c < PHASES; c++) {
            act(&fake.zone[n], compared(c) && comparator_reaches(c, pwm[n]),
                EPWM_TZ_OST_FLAG_DCAEVT1, EPWM_TZ_FLAG_DCAEVT1);
        }
        act(&fake.zone[n], fake.fault && fault_reaches(pwm[n]), EPWM_TZ_OST_FLAG_OST1, 0u);
        act(&fake.zone[n], fake.clock_lost && signal_enabled(pwm[n], EPWM_TZ_SIGNAL_OSHT5),
            EPWM_TZ_OST_FLAG_OST5, 0u);
        act(&fake.zone[n], fake.halted && signal_enabled(pwm[n], EPWM_TZ_SIGNAL_OSHT6),
            EPWM_TZ_OST_FLAG_OST6, 0u);
    }
}

static zone_t *zone_of(uint32_t base) {
    for (int n = 0; n < PHASES; n++) {
        if (pwm[n] == base) {
            return &fake.zone[n];
        }
    }
    return NULL;
}

void fake_set_comparator(uint32_t base, bool active) {
    for (int n = 0; n < PHASES; n++) {
        if (cmpss[n] == base) {
            fake.comparator[n] = active;
        }
    }
    sources_act();
}

void fake_kill_comparator(uint32_t base, bool high) {
    for (int n = 0; n < PHASES; n++) {
        fake.dead_high[n] = fake.dead_high[n] || (high && cmpss[n] == base);
        fake.dead_low[n] = fake.dead_low[n] || (!high && cmpss[n] == base);
    }
}

void fake_set_fault(bool active) {
    fake.fault = active;
    sources_act();
}

void fake_set_clock_lost(bool lost) {
    fake.clock_lost = lost;
    sources_act();
}

void fake_set_halted(bool halted) {
    fake.halted = halted;
    sources_act();
}

bool fake_gates_on(void) {
    for (int n = 0; n < 2 * PHASES; n++) {
        if (!called("GPIO_setPinConfig", pins[n], FAKE_ANY, FAKE_ANY)) {
            return false;
        }
    }
    bool held = false;
    for (int n = 0; n < PHASES; n++) {
        held = held || (fake.zone[n].flags & EPWM_TZ_FLAG_OST) != 0;
    }
    return !held;
}

bool fake_all_tripped(void) {
    return (fake.zone[0].flags & fake.zone[1].flags & fake.zone[2].flags & EPWM_TZ_FLAG_OST) != 0;
}

void EPWM_forceTripZoneEvent(uint32_t base, uint16_t events) {
    call("EPWM_forceTripZoneEvent", (uint32_t[ARGUMENTS]){base, events});
    zone_of(base)->flags |= events & EPWM_TZ_FLAG_OST;
}

void EPWM_clearTripZoneFlag(uint32_t base, uint16_t flags) {
    call("EPWM_clearTripZoneFlag", (uint32_t[ARGUMENTS]){base, flags});
    zone_of(base)->flags &= (uint16_t)~flags;
    sources_act();
}

void EPWM_clearOneShotTripZoneFlag(uint32_t base, uint16_t flags) {
    call("EPWM_clearOneShotTripZoneFlag", (uint32_t[ARGUMENTS]){base, flags});
    zone_of(base)->latches &= (uint16_t)~flags;
    sources_act();
}

uint16_t EPWM_getTripZoneFlagStatus(uint32_t base) {
    return zone_of(base)->flags;
}

uint16_t EPWM_getOneShotTripZoneFlagStatus(uint32_t base) {
    return zone_of(base)->latches;
}

// Read, the register shows its shadow.
uint16_t EPWM_getCounterCompareValue(uint32_t base, EPWM_CounterCompareModule module) {
    const int last = fake_last("EPWM_setCounterCompareValue", base, module, FAKE_ANY);
    return last < 0 ? 0u : (uint16_t)fake_arguments(last)[2];
}

uint16_t EPWM_getTimeBaseCounterDirection(uint32_t base) {
    (void)base;
    return fake.direction;
}

void fake_set_direction(uint16_t direction) {
    fake.direction = direction;
}

// --- the rest ---

static uint16_t *result_of(uint32_t base, ADC_SOCNumber number) {
    return &fake.result[(base - ADCARESULT_BASE) / (ADCBRESULT_BASE - ADCARESULT_BASE)][number];
}

void fake_set_result(uint32_t base, ADC_SOCNumber number, uint16_t count) {
    *result_of(base, number) = count;
}

uint16_t ADC_readResult(uint32_t base, ADC_SOCNumber number) {
    return *result_of(base, number);
}

bool ADC_getInterruptOverflowStatus(uint32_t base, ADC_IntNumber number) {
    (void)base;
    (void)number;
    const bool overflow = fake.overflow;
    fake.overflow = false;
    return overflow;
}

void fake_set_overflow(void) {
    fake.overflow = true;
}

void fake_set_cycles(uint32_t cycles) {
    fake.cycles = cycles;
}

uint32_t CPUTimer_getTimerCount(uint32_t base) {
    (void)base;
    return UINT32_MAX - fake.cycles; // counts down
}

void fake_kill_clock(void) {
    fake.dead = true;
}

uint32_t SysCtl_getClock(uint32_t source_Hz) {
    return fake.dead ? source_Hz / 2u : 100000000u;
}

uint32_t SysCtl_getLowSpeedClock(uint32_t source_Hz) {
    return SysCtl_getClock(source_Hz) / 4u;
}

void fake_set_reset_cause(uint32_t causes) {
    fake.causes = causes;
}

uint32_t SysCtl_getResetCause(void) {
    return fake.causes;
}

void SysCtl_clearResetCause(uint32_t causes) {
    fake.causes &= ~causes;
}

void Device_init(void) {
    call("Device_init", (uint32_t[ARGUMENTS]){0u});
}

void Device_initGPIO(void) {
    call("Device_initGPIO", (uint32_t[ARGUMENTS]){0u});
}

void fake_enable_interrupts(void) {
    call("EINT", (uint32_t[ARGUMENTS]){0u});
}

void Interrupt_register(uint32_t number, void (*handler)(void)) {
    call("Interrupt_register", (uint32_t[ARGUMENTS]){number});
    int n = 0;
    while (n < HANDLERS - 1 && fake.handler[n] != NULL && fake.handler_number[n] != number) {
        n++;
    }
    fake.handler_number[n] = number;
    fake.handler[n] = handler;
}

fake_handler_t fake_handler(uint32_t number) {
    for (int n = 0; n < HANDLERS; n++) {
        if (fake.handler[n] != NULL && fake.handler_number[n] == number) {
            return fake.handler[n];
        }
    }
    return NULL;
}

void fake_serial_room(uint32_t octets) {
    fake.room = octets;
}

const char *fake_serial_text(void) {
    return fake.text;
}

SCI_TxFIFOLevel SCI_getTxFIFOStatus(uint32_t base) {
    (void)base;
    return fake.room > 0u ? SCI_FIFO_TX0 : SCI_FIFO_TX16;
}

void SCI_writeCharNonBlocking(uint32_t base, uint16_t octet) {
    (void)base;
    fake.room--;
    fake.text[fake.text_length++] = (char)octet;
}

// --- calls that are recorded and do nothing ---

#define RECORD_0(name)                                                                             \
    void name(void) {                                                                              \
        call(#name, (uint32_t[ARGUMENTS]){0u});                                                    \
    }
#define RECORD_1(name, T1)                                                                         \
    void name(T1 a) {                                                                              \
        call(#name, (uint32_t[ARGUMENTS]){(uint32_t)(a)});                                         \
    }
#define RECORD_2(name, T1, T2)                                                                     \
    void name(T1 a, T2 b) {                                                                        \
        call(#name, (uint32_t[ARGUMENTS]){(uint32_t)(a), (uint32_t)(b)});                          \
    }
#define RECORD_3(name, T1, T2, T3)                                                                 \
    void name(T1 a, T2 b, T3 c) {                                                                  \
        call(#name, (uint32_t[ARGUMENTS]){(uint32_t)(a), (uint32_t)(b), (uint32_t)(c)});           \
    }
#define RECORD_4(name, T1, T2, T3, T4)                                                             \
    void name(T1 a, T2 b, T3 c, T4 d) {                                                            \
        call(#name,                                                                                \
             (uint32_t[ARGUMENTS]){(uint32_t)(a), (uint32_t)(b), (uint32_t)(c), (uint32_t)(d)});   \
    }
#define RECORD_5(name, T1, T2, T3, T4, T5)                                                         \
    void name(T1 a, T2 b, T3 c, T4 d, T5 e) {                                                      \
        call(#name, (uint32_t[ARGUMENTS]){(uint32_t)(a), (uint32_t)(b), (uint32_t)(c),             \
                                          (uint32_t)(d), (uint32_t)(e)});                          \
    }

RECORD_3(EPWM_setClockPrescaler, uint32_t, EPWM_ClockDivider, EPWM_HSClockDivider)
RECORD_2(EPWM_setEmulationMode, uint32_t, EPWM_EmulationMode)
RECORD_1(EPWM_disablePhaseShiftLoad, uint32_t)
RECORD_2(EPWM_setTimeBasePeriod, uint32_t, uint16_t)
RECORD_2(EPWM_setTimeBaseCounter, uint32_t, uint16_t)
RECORD_2(EPWM_setTimeBaseCounterMode, uint32_t, EPWM_TimeBaseCountMode)
RECORD_3(EPWM_setCounterCompareShadowLoadMode, uint32_t, EPWM_CounterCompareModule,
         EPWM_CounterCompareLoadMode)
RECORD_3(EPWM_setCounterCompareValue, uint32_t, EPWM_CounterCompareModule, uint16_t)
RECORD_4(EPWM_setActionQualifierAction, uint32_t, EPWM_ActionQualifierOutputModule,
         EPWM_ActionQualifierOutput, EPWM_ActionQualifierOutputEvent)
RECORD_2(EPWM_setActionQualifierContSWForceShadowMode, uint32_t, EPWM_ActionQualifierContForce)
RECORD_3(EPWM_setActionQualifierContSWForceAction, uint32_t, EPWM_ActionQualifierOutputModule,
         EPWM_ActionQualifierSWOutput)
RECORD_2(EPWM_setDeadBandCounterClock, uint32_t, EPWM_DeadBandClockMode)
RECORD_2(EPWM_setRisingEdgeDeadBandDelayInput, uint32_t, uint16_t)
RECORD_2(EPWM_setFallingEdgeDeadBandDelayInput, uint32_t, uint16_t)
RECORD_3(EPWM_setDeadBandDelayPolarity, uint32_t, EPWM_DeadBandDelayMode, EPWM_DeadBandPolarity)
RECORD_2(EPWM_setRisingEdgeDelayCount, uint32_t, uint16_t)
RECORD_2(EPWM_setFallingEdgeDelayCount, uint32_t, uint16_t)
RECORD_3(EPWM_setDeadBandDelayMode, uint32_t, EPWM_DeadBandDelayMode, bool)
RECORD_3(EPWM_setTripZoneAction, uint32_t, EPWM_TripZoneEvent, EPWM_TripZoneAction)
RECORD_3(EPWM_selectDigitalCompareTripInput, uint32_t, EPWM_DigitalCompareTripInput,
         EPWM_DigitalCompareType)
RECORD_3(EPWM_setTripZoneDigitalCompareEventCondition, uint32_t, EPWM_TripZoneDigitalCompareOutput,
         EPWM_TripZoneDigitalCompareOutputEvent)
RECORD_4(EPWM_setDigitalCompareEventSource, uint32_t, EPWM_DigitalCompareModule,
         EPWM_DigitalCompareEvent, EPWM_DigitalCompareEventSource)
RECORD_4(EPWM_setDigitalCompareEventSyncMode, uint32_t, EPWM_DigitalCompareModule,
         EPWM_DigitalCompareEvent, EPWM_DigitalCompareSyncMode)
RECORD_2(EPWM_enableTripZoneSignals, uint32_t, uint16_t)
RECORD_2(EPWM_lockRegisters, uint32_t, EPWM_LockRegisterGroup)
RECORD_3(EPWM_setADCTriggerSource, uint32_t, EPWM_ADCStartOfConversionType,
         EPWM_ADCStartOfConversionSource)
RECORD_3(EPWM_setADCTriggerEventPrescale, uint32_t, EPWM_ADCStartOfConversionType, uint16_t)
RECORD_2(EPWM_enableADCTrigger, uint32_t, EPWM_ADCStartOfConversionType)
RECORD_3(ADC_setVREF, uint32_t, ADC_ReferenceMode, ADC_ReferenceVoltage)
RECORD_2(ADC_setPrescaler, uint32_t, ADC_ClkPrescale)
RECORD_2(ADC_setInterruptPulseMode, uint32_t, ADC_PulseMode)
RECORD_1(ADC_enableConverter, uint32_t)
RECORD_2(ADC_setSOCPriority, uint32_t, ADC_PriorityMode)
RECORD_5(ADC_setupSOC, uint32_t, ADC_SOCNumber, ADC_Trigger, ADC_Channel, uint32_t)
RECORD_3(ADC_setInterruptSource, uint32_t, ADC_IntNumber, ADC_SOCNumber)
RECORD_2(ADC_clearInterruptStatus, uint32_t, ADC_IntNumber)
RECORD_2(ADC_clearInterruptOverflowStatus, uint32_t, ADC_IntNumber)
RECORD_2(ADC_enableInterrupt, uint32_t, ADC_IntNumber)
RECORD_2(PGA_setGain, uint32_t, PGA_GainMode)
RECORD_2(PGA_setFilterResistor, uint32_t, PGA_LowPassResistorValue)
RECORD_1(PGA_enable, uint32_t)
RECORD_2(DAC_setReferenceVoltage, uint32_t, DAC_ReferenceVoltage)
RECORD_2(DAC_setGainMode, uint32_t, DAC_GainMode)
RECORD_2(DAC_setLoadMode, uint32_t, DAC_LoadMode)
RECORD_2(DAC_setShadowValue, uint32_t, uint16_t)
RECORD_1(DAC_enableOutput, uint32_t)
RECORD_2(ASysCtl_selectCMPHPMux, ASysCtl_CMPHPMuxSelect, uint32_t)
RECORD_2(ASysCtl_selectCMPLPMux, ASysCtl_CMPLPMuxSelect, uint32_t)
RECORD_2(CMPSS_configDAC, uint32_t, uint16_t)

void CMPSS_setDACValueHigh(uint32_t base, uint16_t value) {
    call("CMPSS_setDACValueHigh", (uint32_t[ARGUMENTS]){base, value});
    sources_act();
}

void CMPSS_setDACValueLow(uint32_t base, uint16_t value) {
    call("CMPSS_setDACValueLow", (uint32_t[ARGUMENTS]){base, value});
    sources_act();
}

RECORD_2(CMPSS_configHighComparator, uint32_t, uint16_t)
RECORD_2(CMPSS_configLowComparator, uint32_t, uint16_t)
RECORD_4(CMPSS_configFilterHigh, uint32_t, uint16_t, uint16_t, uint16_t)
RECORD_4(CMPSS_configFilterLow, uint32_t, uint16_t, uint16_t, uint16_t)
RECORD_1(CMPSS_initFilterHigh, uint32_t)
RECORD_1(CMPSS_initFilterLow, uint32_t)
RECORD_2(CMPSS_configOutputsHigh, uint32_t, uint16_t)
RECORD_2(CMPSS_configOutputsLow, uint32_t, uint16_t)
RECORD_1(CMPSS_enableModule, uint32_t)
RECORD_2(XBAR_setEPWMMuxConfig, XBAR_TripNum, XBAR_EPWMMuxConfig)
RECORD_2(XBAR_enableEPWMMux, XBAR_TripNum, uint32_t)
RECORD_2(XBAR_setInputPin, XBAR_InputNum, uint16_t)
RECORD_1(XBAR_lockInput, XBAR_InputNum)
RECORD_2(GPIO_setPadConfig, uint32_t, uint32_t)
RECORD_2(GPIO_setQualificationMode, uint32_t, GPIO_QualificationMode)
RECORD_2(GPIO_setDirectionMode, uint32_t, GPIO_Direction)
RECORD_1(GPIO_setPinConfig, uint32_t)
RECORD_2(GPIO_writePin, uint32_t, uint32_t)
RECORD_1(SCI_performSoftwareReset, uint32_t)
RECORD_4(SCI_setConfig, uint32_t, uint32_t, uint32_t, uint32_t)
RECORD_1(SCI_enableFIFO, uint32_t)
RECORD_1(SCI_resetTxFIFO, uint32_t)
RECORD_1(SCI_enableModule, uint32_t)
RECORD_1(CPUTimer_stopTimer, uint32_t)
RECORD_2(CPUTimer_setPreScaler, uint32_t, uint16_t)
RECORD_2(CPUTimer_setPeriod, uint32_t, uint32_t)
RECORD_2(CPUTimer_setEmulationMode, uint32_t, CPUTimer_EmulationMode)
RECORD_1(CPUTimer_reloadTimerCounter, uint32_t)
RECORD_1(CPUTimer_startTimer, uint32_t)
RECORD_1(SysCtl_setWatchdogMode, SysCtl_WDMode)
RECORD_1(SysCtl_setWatchdogPrescaler, SysCtl_WDPrescaler)
RECORD_0(SysCtl_serviceWatchdog)
RECORD_0(SysCtl_enableWatchdog)
RECORD_0(SysCtl_disableWatchdog)
RECORD_1(SysCtl_enablePeripheral, SysCtl_PeripheralPCLOCKCR)
RECORD_1(SysCtl_disablePeripheral, SysCtl_PeripheralPCLOCKCR)
RECORD_1(SysCtl_delay, uint32_t)
RECORD_0(Interrupt_initModule)
RECORD_0(Interrupt_initVectorTable)
RECORD_1(Interrupt_enable, uint32_t)
RECORD_1(Interrupt_clearACKGroup, uint16_t)
