/// Hand-written stand-ins for the names of TI's C2000Ware driverlib (F28004x) that port/ti_f28004x uses.
/// Values of constants are TI's or merely distinct; the functions record their calls (f28004x.h).
#ifndef FAKES_TI_DRIVERLIB_H
#define FAKES_TI_DRIVERLIB_H

#include <stdbool.h>
#include <stdint.h>

// The compiler's keyword, and an instruction that the real header spells so.
#define __interrupt
void fake_enable_interrupts(void);
#define EINT fake_enable_interrupts()

#define EPWM3_BASE 0x4200u
#define EPWM5_BASE 0x4400u
#define EPWM6_BASE 0x4500u
#define ADCA_BASE 0x7400u
#define ADCB_BASE 0x7480u
#define ADCC_BASE 0x7500u
#define ADCARESULT_BASE 0x0B00u
#define ADCBRESULT_BASE 0x0B20u
#define ADCCRESULT_BASE 0x0B40u
#define CMPSS1_BASE 0x5C80u
#define CMPSS3_BASE 0x5CC0u
#define CMPSS5_BASE 0x5D00u
#define PGA1_BASE 0x5B00u
#define PGA3_BASE 0x5B20u
#define PGA5_BASE 0x5B40u
#define DACB_BASE 0x5C10u
#define CPUTIMER1_BASE 0x0C08u
#define SCIA_BASE 0x7200u
#define GPIO_4_EPWM3_A 0x00060801uL
#define GPIO_5_EPWM3_B 0x00060A01uL
#define GPIO_8_EPWM5_A 0x00061001uL
#define GPIO_9_EPWM5_B 0x00061201uL
#define GPIO_10_EPWM6_A 0x00061401uL
#define GPIO_11_EPWM6_B 0x00061601uL
#define GPIO_13_GPIO13 0x00061A00uL
#define GPIO_40_GPIO40 0x00461000uL
#define GPIO_29_SCIA_TX 0x00081A01uL
#define INT_ADCB1 0x00210102uL
#define INT_NMI 0x00120000uL
#define INT_ILLEGAL 0x00130000uL
#define INTERRUPT_ACK_GROUP1 0x1u
#define EPWM_TZ_SIGNAL_OSHT1 0x0100u
#define EPWM_TZ_SIGNAL_OSHT5 0x1000u
#define EPWM_TZ_SIGNAL_OSHT6 0x2000u
#define EPWM_TZ_SIGNAL_DCAEVT1 0x4000u
#define EPWM_TZ_FLAG_OST 0x4u
#define EPWM_TZ_FLAG_DCAEVT1 0x8u
#define EPWM_TZ_FORCE_EVENT_OST 0x4u
#define EPWM_TZ_OST_FLAG_OST1 0x01u
#define EPWM_TZ_OST_FLAG_OST5 0x10u
#define EPWM_TZ_OST_FLAG_OST6 0x20u
#define EPWM_TZ_OST_FLAG_DCAEVT1 0x40u
#define EPWM_TIME_BASE_STATUS_COUNT_DOWN 0u
#define EPWM_TIME_BASE_STATUS_COUNT_UP 1u
#define EPWM_DB_INPUT_EPWMA 0u
#define CMPSS_INSRC_DAC 0x0000u
#define CMPSS_INV_INVERTED 0x0002u
#define CMPSS_TRIPOUT_FILTER 0x0020u
#define CMPSS_TRIP_FILTER 0x0008u
#define CMPSS_DACVAL_SYSCLK 0x0000u
#define CMPSS_DACREF_VDDA 0x0000u
#define CMPSS_DACSRC_SHDW 0x0000u
#define XBAR_MUX00 0x00000001uL
#define XBAR_MUX04 0x00000010uL
#define XBAR_MUX08 0x00000100uL
#define GPIO_PIN_TYPE_STD 0x0u
#define GPIO_PIN_TYPE_PULLUP 0x1u
#define SCI_CONFIG_WLEN_8 0x7uL
#define SCI_CONFIG_STOP_ONE 0x0uL

typedef enum { EPWM_CLOCK_DIVIDER_1 = 0 } EPWM_ClockDivider;
typedef enum { EPWM_HSCLOCK_DIVIDER_1 = 0 } EPWM_HSClockDivider;
typedef enum { EPWM_EMULATION_FREE_RUN = 2 } EPWM_EmulationMode;
typedef enum { EPWM_COUNTER_MODE_UP_DOWN = 2 } EPWM_TimeBaseCountMode;
typedef enum { EPWM_COUNTER_COMPARE_A = 0 } EPWM_CounterCompareModule;
typedef enum {
    EPWM_COMP_LOAD_ON_CNTR_ZERO = 0,
    EPWM_COMP_LOAD_ON_CNTR_PERIOD = 1,
    EPWM_COMP_LOAD_ON_CNTR_ZERO_PERIOD = 2
} EPWM_CounterCompareLoadMode;
typedef enum { EPWM_AQ_OUTPUT_A = 0, EPWM_AQ_OUTPUT_B = 2 } EPWM_ActionQualifierOutputModule;
typedef enum { EPWM_AQ_OUTPUT_LOW = 1, EPWM_AQ_OUTPUT_HIGH = 2 } EPWM_ActionQualifierOutput;
typedef enum {
    EPWM_AQ_OUTPUT_ON_TIMEBASE_UP_CMPA = 4,
    EPWM_AQ_OUTPUT_ON_TIMEBASE_DOWN_CMPA = 6
} EPWM_ActionQualifierOutputEvent;
typedef enum { EPWM_DB_COUNTER_CLOCK_FULL_CYCLE = 0 } EPWM_DeadBandClockMode;
typedef enum {
    EPWM_DB_POLARITY_ACTIVE_HIGH = 0,
    EPWM_DB_POLARITY_ACTIVE_LOW = 1
} EPWM_DeadBandPolarity;
typedef enum { EPWM_AQ_SW_DISABLED = 0, EPWM_AQ_SW_OUTPUT_LOW = 1 } EPWM_ActionQualifierSWOutput;
typedef enum { EPWM_AQ_SW_IMMEDIATE_LOAD = 3 } EPWM_ActionQualifierContForce;
typedef enum { EPWM_DB_FED = 0, EPWM_DB_RED = 1 } EPWM_DeadBandDelayMode;
typedef enum { EPWM_TZ_ACTION_EVENT_TZA = 0, EPWM_TZ_ACTION_EVENT_TZB = 2 } EPWM_TripZoneEvent;
typedef enum {
    EPWM_TZ_ACTION_HIGH_Z = 0,
    EPWM_TZ_ACTION_HIGH = 1,
    EPWM_TZ_ACTION_LOW = 2
} EPWM_TripZoneAction;
typedef enum { EPWM_DC_TRIP_TRIPIN4 = 3 } EPWM_DigitalCompareTripInput;
typedef enum { EPWM_DC_TYPE_DCAH = 0 } EPWM_DigitalCompareType;
typedef enum { EPWM_TZ_DC_OUTPUT_A1 = 0 } EPWM_TripZoneDigitalCompareOutput;
typedef enum { EPWM_TZ_EVENT_DCXH_HIGH = 2 } EPWM_TripZoneDigitalCompareOutputEvent;
typedef enum { EPWM_DC_MODULE_A = 0 } EPWM_DigitalCompareModule;
typedef enum { EPWM_DC_EVENT_1 = 0 } EPWM_DigitalCompareEvent;
typedef enum { EPWM_DC_EVENT_SOURCE_ORIG_SIGNAL = 0 } EPWM_DigitalCompareEventSource;
typedef enum { EPWM_DC_EVENT_INPUT_NOT_SYNCED = 1 } EPWM_DigitalCompareSyncMode;
typedef enum {
    EPWM_REGISTER_GROUP_TRIP_ZONE = 0x4,
    EPWM_REGISTER_GROUP_DIGITAL_COMPARE = 0x10
} EPWM_LockRegisterGroup;
typedef enum { EPWM_SOC_A = 0 } EPWM_ADCStartOfConversionType;
typedef enum {
    EPWM_SOC_TBCTR_ZERO = 1,
    EPWM_SOC_TBCTR_PERIOD = 2,
    EPWM_SOC_TBCTR_ZERO_OR_PERIOD = 3
} EPWM_ADCStartOfConversionSource;
typedef enum { ADC_REFERENCE_INTERNAL = 0 } ADC_ReferenceMode;
typedef enum { ADC_REFERENCE_3_3V = 0 } ADC_ReferenceVoltage;
typedef enum { ADC_CLK_DIV_2_0 = 2 } ADC_ClkPrescale;
typedef enum { ADC_PULSE_END_OF_CONV = 4 } ADC_PulseMode;
typedef enum { ADC_PRI_ALL_HIPRI = 16 } ADC_PriorityMode;
typedef enum { ADC_SOC_NUMBER0 = 0, ADC_SOC_NUMBER1 = 1 } ADC_SOCNumber;
typedef enum { ADC_TRIGGER_EPWM1_SOCA = 5, ADC_TRIGGER_EPWM6_SOCA = 15 } ADC_Trigger;
typedef enum { ADC_CH_ADCIN1 = 1, ADC_CH_ADCIN7 = 7, ADC_CH_ADCIN14 = 14 } ADC_Channel;
typedef enum { ADC_INT_NUMBER1 = 0 } ADC_IntNumber;
typedef enum { PGA_GAIN_12 = 2 } PGA_GainMode;
typedef enum { PGA_LOW_PASS_FILTER_DISABLED = 0 } PGA_LowPassResistorValue;
typedef enum { DAC_REF_ADC_VREFHI = 1 } DAC_ReferenceVoltage;
typedef enum { DAC_GAIN_TWO = 2 } DAC_GainMode;
typedef enum { DAC_LOAD_SYSCLK = 0 } DAC_LoadMode;
typedef enum {
    ASYSCTL_CMPHPMUX_SELECT_1 = 0,
    ASYSCTL_CMPHPMUX_SELECT_3 = 6,
    ASYSCTL_CMPHPMUX_SELECT_5 = 12
} ASysCtl_CMPHPMuxSelect;
typedef enum {
    ASYSCTL_CMPLPMUX_SELECT_1 = 0,
    ASYSCTL_CMPLPMUX_SELECT_3 = 6,
    ASYSCTL_CMPLPMUX_SELECT_5 = 12
} ASysCtl_CMPLPMuxSelect;
typedef enum { XBAR_TRIP4 = 0 } XBAR_TripNum;
typedef enum { XBAR_INPUT1 = 0 } XBAR_InputNum;
typedef enum {
    XBAR_EPWM_MUX00_CMPSS1_CTRIPH_OR_L = 0x0001,
    XBAR_EPWM_MUX04_CMPSS3_CTRIPH_OR_L = 0x0801,
    XBAR_EPWM_MUX08_CMPSS5_CTRIPH_OR_L = 0x1001
} XBAR_EPWMMuxConfig;
typedef enum { GPIO_QUAL_ASYNC = 3 } GPIO_QualificationMode;
typedef enum { GPIO_DIR_MODE_IN = 0, GPIO_DIR_MODE_OUT = 1 } GPIO_Direction;
typedef enum { CPUTIMER_EMULATIONMODE_RUNFREE = 0x800 } CPUTimer_EmulationMode;
typedef enum { SCI_FIFO_TX0 = 0, SCI_FIFO_TX16 = 16 } SCI_TxFIFOLevel;
#define SYSCTL_CAUSE_XRS 0x2u
#define SYSCTL_CAUSE_WDRS 0x4u
#define SYSCTL_CAUSE_NMIWDRS 0x8u
typedef enum { SYSCTL_WD_MODE_RESET = 0 } SysCtl_WDMode;
typedef enum { SYSCTL_WD_PRESCALE_1 = 0 } SysCtl_WDPrescaler;
typedef enum {
    SYSCTL_PERIPH_CLK_TIMER1 = 0x0400,
    SYSCTL_PERIPH_CLK_TBCLKSYNC = 0x1200,
    SYSCTL_PERIPH_CLK_EPWM3 = 0x0202,
    SYSCTL_PERIPH_CLK_EPWM5 = 0x0402,
    SYSCTL_PERIPH_CLK_EPWM6 = 0x0502,
    SYSCTL_PERIPH_CLK_SCIA = 0x0007,
    SYSCTL_PERIPH_CLK_ADCA = 0x000D,
    SYSCTL_PERIPH_CLK_ADCB = 0x010D,
    SYSCTL_PERIPH_CLK_ADCC = 0x020D,
    SYSCTL_PERIPH_CLK_CMPSS1 = 0x000E,
    SYSCTL_PERIPH_CLK_CMPSS3 = 0x020E,
    SYSCTL_PERIPH_CLK_CMPSS5 = 0x040E,
    SYSCTL_PERIPH_CLK_PGA1 = 0x000F,
    SYSCTL_PERIPH_CLK_PGA3 = 0x020F,
    SYSCTL_PERIPH_CLK_PGA5 = 0x040F,
    SYSCTL_PERIPH_CLK_DACB = 0x1110
} SysCtl_PeripheralPCLOCKCR;

void EPWM_setClockPrescaler(uint32_t, EPWM_ClockDivider, EPWM_HSClockDivider);
void EPWM_setEmulationMode(uint32_t, EPWM_EmulationMode);
void EPWM_disablePhaseShiftLoad(uint32_t);
void EPWM_setTimeBasePeriod(uint32_t, uint16_t);
void EPWM_setTimeBaseCounter(uint32_t, uint16_t);
void EPWM_setTimeBaseCounterMode(uint32_t, EPWM_TimeBaseCountMode);
void EPWM_setCounterCompareShadowLoadMode(uint32_t, EPWM_CounterCompareModule,
                                          EPWM_CounterCompareLoadMode);
void EPWM_setCounterCompareValue(uint32_t, EPWM_CounterCompareModule, uint16_t);
uint16_t EPWM_getCounterCompareValue(uint32_t, EPWM_CounterCompareModule);
void EPWM_setActionQualifierAction(uint32_t, EPWM_ActionQualifierOutputModule,
                                   EPWM_ActionQualifierOutput, EPWM_ActionQualifierOutputEvent);
void EPWM_setDeadBandCounterClock(uint32_t, EPWM_DeadBandClockMode);
void EPWM_setRisingEdgeDeadBandDelayInput(uint32_t, uint16_t);
void EPWM_setFallingEdgeDeadBandDelayInput(uint32_t, uint16_t);
void EPWM_setDeadBandDelayPolarity(uint32_t, EPWM_DeadBandDelayMode, EPWM_DeadBandPolarity);
void EPWM_setRisingEdgeDelayCount(uint32_t, uint16_t);
void EPWM_setFallingEdgeDelayCount(uint32_t, uint16_t);
void EPWM_setActionQualifierContSWForceShadowMode(uint32_t, EPWM_ActionQualifierContForce);
void EPWM_setActionQualifierContSWForceAction(uint32_t, EPWM_ActionQualifierOutputModule,
                                              EPWM_ActionQualifierSWOutput);
void EPWM_setDeadBandDelayMode(uint32_t, EPWM_DeadBandDelayMode, bool);
void EPWM_setTripZoneAction(uint32_t, EPWM_TripZoneEvent, EPWM_TripZoneAction);
void EPWM_selectDigitalCompareTripInput(uint32_t, EPWM_DigitalCompareTripInput,
                                        EPWM_DigitalCompareType);
void EPWM_setTripZoneDigitalCompareEventCondition(uint32_t, EPWM_TripZoneDigitalCompareOutput,
                                                  EPWM_TripZoneDigitalCompareOutputEvent);
void EPWM_setDigitalCompareEventSource(uint32_t, EPWM_DigitalCompareModule,
                                       EPWM_DigitalCompareEvent, EPWM_DigitalCompareEventSource);
void EPWM_setDigitalCompareEventSyncMode(uint32_t, EPWM_DigitalCompareModule,
                                         EPWM_DigitalCompareEvent, EPWM_DigitalCompareSyncMode);
void EPWM_enableTripZoneSignals(uint32_t, uint16_t);
void EPWM_lockRegisters(uint32_t, EPWM_LockRegisterGroup);
void EPWM_forceTripZoneEvent(uint32_t, uint16_t);
void EPWM_clearTripZoneFlag(uint32_t, uint16_t);
void EPWM_clearOneShotTripZoneFlag(uint32_t, uint16_t);
void EPWM_setADCTriggerSource(uint32_t, EPWM_ADCStartOfConversionType,
                              EPWM_ADCStartOfConversionSource);
void EPWM_setADCTriggerEventPrescale(uint32_t, EPWM_ADCStartOfConversionType, uint16_t);
void EPWM_enableADCTrigger(uint32_t, EPWM_ADCStartOfConversionType);
void ADC_setVREF(uint32_t, ADC_ReferenceMode, ADC_ReferenceVoltage);
void ADC_setPrescaler(uint32_t, ADC_ClkPrescale);
void ADC_setInterruptPulseMode(uint32_t, ADC_PulseMode);
void ADC_enableConverter(uint32_t);
void ADC_setSOCPriority(uint32_t, ADC_PriorityMode);
void ADC_setupSOC(uint32_t, ADC_SOCNumber, ADC_Trigger, ADC_Channel, uint32_t);
void ADC_setInterruptSource(uint32_t, ADC_IntNumber, ADC_SOCNumber);
void ADC_clearInterruptStatus(uint32_t, ADC_IntNumber);
void ADC_clearInterruptOverflowStatus(uint32_t, ADC_IntNumber);
void ADC_enableInterrupt(uint32_t, ADC_IntNumber);
void PGA_setGain(uint32_t, PGA_GainMode);
void PGA_setFilterResistor(uint32_t, PGA_LowPassResistorValue);
void PGA_enable(uint32_t);
void DAC_setReferenceVoltage(uint32_t, DAC_ReferenceVoltage);
void DAC_setGainMode(uint32_t, DAC_GainMode);
void DAC_setLoadMode(uint32_t, DAC_LoadMode);
void DAC_setShadowValue(uint32_t, uint16_t);
void DAC_enableOutput(uint32_t);
void ASysCtl_selectCMPHPMux(ASysCtl_CMPHPMuxSelect, uint32_t);
void ASysCtl_selectCMPLPMux(ASysCtl_CMPLPMuxSelect, uint32_t);
void CMPSS_configDAC(uint32_t, uint16_t);
void CMPSS_setDACValueHigh(uint32_t, uint16_t);
void CMPSS_setDACValueLow(uint32_t, uint16_t);
void CMPSS_configHighComparator(uint32_t, uint16_t);
void CMPSS_configLowComparator(uint32_t, uint16_t);
void CMPSS_configFilterHigh(uint32_t, uint16_t, uint16_t, uint16_t);
void CMPSS_configFilterLow(uint32_t, uint16_t, uint16_t, uint16_t);
void CMPSS_initFilterHigh(uint32_t);
void CMPSS_initFilterLow(uint32_t);
void CMPSS_configOutputsHigh(uint32_t, uint16_t);
void CMPSS_configOutputsLow(uint32_t, uint16_t);
void CMPSS_enableModule(uint32_t);
void XBAR_setEPWMMuxConfig(XBAR_TripNum, XBAR_EPWMMuxConfig);
void XBAR_enableEPWMMux(XBAR_TripNum, uint32_t);
void XBAR_setInputPin(XBAR_InputNum, uint16_t);
void XBAR_lockInput(XBAR_InputNum);
void GPIO_setPadConfig(uint32_t, uint32_t);
void GPIO_setQualificationMode(uint32_t, GPIO_QualificationMode);
void GPIO_setDirectionMode(uint32_t, GPIO_Direction);
void GPIO_setPinConfig(uint32_t);
void GPIO_writePin(uint32_t, uint32_t);
void SCI_performSoftwareReset(uint32_t);
void SCI_setConfig(uint32_t, uint32_t, uint32_t, uint32_t);
void SCI_enableFIFO(uint32_t);
void SCI_resetTxFIFO(uint32_t);
void SCI_enableModule(uint32_t);
void CPUTimer_stopTimer(uint32_t);
void CPUTimer_setPreScaler(uint32_t, uint16_t);
void CPUTimer_setPeriod(uint32_t, uint32_t);
void CPUTimer_setEmulationMode(uint32_t, CPUTimer_EmulationMode);
void CPUTimer_reloadTimerCounter(uint32_t);
void CPUTimer_startTimer(uint32_t);
void SysCtl_setWatchdogMode(SysCtl_WDMode);
void SysCtl_setWatchdogPrescaler(SysCtl_WDPrescaler);
void SysCtl_serviceWatchdog(void);
void SysCtl_enableWatchdog(void);
void SysCtl_disableWatchdog(void);
void SysCtl_enablePeripheral(SysCtl_PeripheralPCLOCKCR);
void SysCtl_disablePeripheral(SysCtl_PeripheralPCLOCKCR);
void SysCtl_delay(uint32_t);
void Interrupt_initModule(void);
void Interrupt_initVectorTable(void);
void Interrupt_enable(uint32_t);
void Interrupt_clearACKGroup(uint16_t);
void Interrupt_register(uint32_t number, void (*handler)(void));
uint16_t EPWM_getTripZoneFlagStatus(uint32_t base);
uint16_t EPWM_getOneShotTripZoneFlagStatus(uint32_t base);
uint16_t EPWM_getTimeBaseCounterDirection(uint32_t base);
uint16_t ADC_readResult(uint32_t base, ADC_SOCNumber number);
bool ADC_getInterruptOverflowStatus(uint32_t base, ADC_IntNumber number);
uint32_t CPUTimer_getTimerCount(uint32_t base);
uint32_t SysCtl_getClock(uint32_t source_Hz);
uint32_t SysCtl_getLowSpeedClock(uint32_t source_Hz);
uint32_t SysCtl_getResetCause(void);
void SysCtl_clearResetCause(uint32_t causes);
SCI_TxFIFOLevel SCI_getTxFIFOStatus(uint32_t base);
void SCI_writeCharNonBlocking(uint32_t base, uint16_t octet);

#endif
