/// TI LAUNCHXL-F280049C with a BOOSTXL-DRV8320RS on J1 .. J4: three low-side shunts into the chip's own
/// programmable amplifiers (PGA), over-current by its comparators and by the driver's nFAULT.
#ifndef LODESTAR_PORT_BOARD_VARIANT_H
#define LODESTAR_PORT_BOARD_VARIANT_H

#define VARIANT_F_PWM_Hz 20000u
#define VARIANT_DEAD_TIME_ns 200u // above the 100 ns of the driver, which then adds nothing
#define VARIANT_PRECHARGE_s 0.0f  // the driver has a charge pump

// Power stage: 6 .. 54 V, 15 A peak.
#define VARIANT_V_BUS_V 24.0f
#define VARIANT_I_MAX_A 12.0f
#define VARIANT_V_DROP_V 0.0f
#define VARIANT_R_ON_Ohm 0.0f

// Shunt 7 mOhm; 2.49 kOhm to the shunt and 27.4 kOhm to 1.65 V (DACB) lift the signal above ground; PGA gain 12. A
// current into the motor pulls the shunt below ground: negative gain. Full scale 42.86 A.
#define VARIANT_V_REF_V 3.3f
#define VARIANT_COUNTS 4096.0f
#define VARIANT_SHUNT_Ohm 0.007f
#define VARIANT_DIVIDER (27.4f / (27.4f + 2.49f))
#define VARIANT_AMPLIFIER 12.0f
#define VARIANT_I_GAIN_A_count                                                                     \
    (-VARIANT_V_REF_V / VARIANT_COUNTS / (VARIANT_SHUNT_Ohm * VARIANT_DIVIDER * VARIANT_AMPLIFIER))
#define VARIANT_BIAS_V 1.65f
#define VARIANT_I_OFFSET_count                                                                     \
    (VARIANT_BIAS_V * (1.0f - VARIANT_DIVIDER) * VARIANT_AMPLIFIER / VARIANT_V_REF_V *             \
     VARIANT_COUNTS)
#define VARIANT_I_OFFSET_TOL_count 200.0f // resistors of 1 %, the DAC's and the amplifier's offset
#define VARIANT_V_BUS_GAIN_V_count                                                                 \
    (VARIANT_V_REF_V / VARIANT_COUNTS * (82.0f + 4.99f) / 4.99f) // 82 kOhm over 4.99 kOhm
#define VARIANT_T_GAIN_degC_count 0.0f                           // no temperature sensor
#define VARIANT_T_OFFSET_degC 0.0f
#define VARIANT_T_MAX_degC 0.0f // 0: the default of the library
// Dead time, then three times the settling time of the amplifier, about 0.5 us to 0.1 % at gain 12.
#define VARIANT_SETTLE_ns 1700.0f
#define VARIANT_TRIP_MAX_A 18.0f // the range of the amplifier is 21.4 A, either sign
#define VARIANT_TRIP_MIN_A 2.0f

// Phases a, b, c. All three ePWM count in phase; the first one triggers the ADCs.
#define VARIANT_PWM                                                                                \
    { EPWM6_BASE, EPWM5_BASE, EPWM3_BASE }
#define VARIANT_PWM_CLOCKS                                                                         \
    { SYSCTL_PERIPH_CLK_EPWM6, SYSCTL_PERIPH_CLK_EPWM5, SYSCTL_PERIPH_CLK_EPWM3 }
#define VARIANT_TRIGGER ADC_TRIGGER_EPWM6_SOCA
#define VARIANT_PWM_PINS                                                                           \
    {GPIO_10_EPWM6_A, 10u}, {GPIO_11_EPWM6_B, 11u}, {GPIO_8_EPWM5_A, 8u}, {GPIO_9_EPWM5_B, 9u},    \
        {GPIO_4_EPWM3_A, 4u}, {                                                                    \
        GPIO_5_EPWM3_B, 5u                                                                         \
    }

// ADC, channel and result of phases a, b, c: PGA5_OUT on A14, PGA3_OUT on C7, PGA1_OUT on B7.
#define VARIANT_CURRENTS                                                                           \
    {ADCA_BASE, ADCARESULT_BASE, ADC_CH_ADCIN14}, {ADCC_BASE, ADCCRESULT_BASE, ADC_CH_ADCIN7}, {   \
        ADCB_BASE, ADCBRESULT_BASE, ADC_CH_ADCIN7                                                  \
    }
// The bus is converted after a current on the same ADC, so that its end is the end of all conversions.
#define VARIANT_BUS_ADC ADCB_BASE
#define VARIANT_BUS_RESULT ADCBRESULT_BASE
#define VARIANT_BUS_CHANNEL ADC_CH_ADCIN1
#define VARIANT_PERIOD_INT INT_ADCB1
#define VARIANT_PERIOD_GROUP INTERRUPT_ACK_GROUP1
#define VARIANT_PGA                                                                                \
    { PGA5_BASE, PGA3_BASE, PGA1_BASE }
#define VARIANT_PGA_CLOCKS                                                                         \
    { SYSCTL_PERIPH_CLK_PGA5, SYSCTL_PERIPH_CLK_PGA3, SYSCTL_PERIPH_CLK_PGA1 }

// Comparators 5, 3 and 1 on the amplifiers' outputs (input 4), and their route through the ePWM X-BAR.
#define VARIANT_COMPARATORS                                                                        \
    {CMPSS5_BASE,                                                                                  \
     SYSCTL_PERIPH_CLK_CMPSS5,                                                                     \
     ASYSCTL_CMPHPMUX_SELECT_5,                                                                    \
     ASYSCTL_CMPLPMUX_SELECT_5,                                                                    \
     XBAR_EPWM_MUX08_CMPSS5_CTRIPH_OR_L,                                                           \
     XBAR_MUX08},                                                                                  \
        {CMPSS3_BASE,                                                                              \
         SYSCTL_PERIPH_CLK_CMPSS3,                                                                 \
         ASYSCTL_CMPHPMUX_SELECT_3,                                                                \
         ASYSCTL_CMPLPMUX_SELECT_3,                                                                \
         XBAR_EPWM_MUX04_CMPSS3_CTRIPH_OR_L,                                                       \
         XBAR_MUX04},                                                                              \
    {                                                                                              \
        CMPSS1_BASE, SYSCTL_PERIPH_CLK_CMPSS1, ASYSCTL_CMPHPMUX_SELECT_1,                          \
            ASYSCTL_CMPLPMUX_SELECT_1, XBAR_EPWM_MUX00_CMPSS1_CTRIPH_OR_L, XBAR_MUX00              \
    }
#define VARIANT_COMPARATOR_INPUT 4u

// The gate driver.
#define VARIANT_ENABLE_GPIO 13u
#define VARIANT_ENABLE_PIN GPIO_13_GPIO13
#define VARIANT_FAULT_GPIO 40u // active low
#define VARIANT_FAULT_PIN GPIO_40_GPIO40
#define VARIANT_TX_GPIO 29u // SCIA, the XDS110's virtual COM port
#define VARIANT_TX_PIN GPIO_29_SCIA_TX

#endif
