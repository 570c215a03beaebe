/// An AM263x with any inverter of six gate inputs, three low-side shunts with amplifiers biased to the
/// middle of the range, an enable and an active-low fault line. The values are those of a 24 V, 10 A stage:
/// copy this file and enter those of your board.
#ifndef LODESTAR_PORT_BOARD_VARIANT_H
#define LODESTAR_PORT_BOARD_VARIANT_H

#define VARIANT_F_PWM_Hz 20000u
#define VARIANT_DEAD_TIME_ns 300u
#define VARIANT_PRECHARGE_s 10.0e-3f // of bootstrap capacitors; 0: none

// Power stage.
#define VARIANT_V_BUS_V 24.0f
#define VARIANT_I_MAX_A 10.0f
#define VARIANT_V_DROP_V 0.0f
#define VARIANT_R_ON_Ohm 0.0f

// Shunt 5 mOhm, amplifier gain 20. A current into the motor pulls the low-side shunt below ground.
#define VARIANT_V_REF_V 3.2f // the ADC's full scale with VREFHI of 1.8 V
#define VARIANT_V_DAC_V 3.3f // the comparators' full scale: VDDA
#define VARIANT_COUNTS 4096.0f
#define VARIANT_SHUNT_Ohm 0.005f
#define VARIANT_AMPLIFIER 20.0f
#define VARIANT_BIAS_V 1.6f
#define VARIANT_I_GAIN_A_count                                                                     \
    (-VARIANT_V_REF_V / VARIANT_COUNTS / (VARIANT_SHUNT_Ohm * VARIANT_AMPLIFIER))
#define VARIANT_I_OFFSET_count (VARIANT_BIAS_V / VARIANT_V_REF_V * VARIANT_COUNTS)
#define VARIANT_I_OFFSET_TOL_count 100.0f
#define VARIANT_V_BUS_GAIN_V_count                                                                 \
    (VARIANT_V_REF_V / VARIANT_COUNTS * (82.0f + 4.99f) / 4.99f) // 82 kOhm over 4.99 kOhm
// NTC of 10 kOhm and B = 3435 K between the ADC's input and ground, 10 kOhm up to the ADC's full
// scale; the points are those of the B equation. Enter the table of your data sheet.
#define VARIANT_NTC_POINTS                                                                         \
    {-40.0f, 248277.0f}, {-30.0f, 135452.0f}, {-20.0f, 77523.0f}, {-10.0f, 46290.0f},              \
        {0.0f, 28704.0f}, {10.0f, 18410.0f}, {20.0f, 12171.0f}, {30.0f, 8269.0f},                  \
        {40.0f, 5759.0f}, {50.0f, 4101.0f}, {60.0f, 2981.0f}, {70.0f, 2207.0f}, {80.0f, 1662.0f},  \
        {90.0f, 1272.0f}, {100.0f, 987.0f}, {110.0f, 776.0f}, {120.0f, 618.0f}, {130.0f, 498.0f},  \
        {140.0f, 405.0f}, {                                                                        \
        150.0f, 333.0f                                                                             \
    }
#define VARIANT_NTC_FIXED_Ohm 10000.0f
#define VARIANT_NTC_TO_GROUND true
#define VARIANT_T_GAIN_degC_count PORT_NTC_GAIN_degC
#define VARIANT_T_OFFSET_degC PORT_NTC_ZERO_degC
#define VARIANT_T_MAX_degC 100.0f
#define VARIANT_SETTLE_ns 1700.0f
#define VARIANT_TRIP_MAX_A 14.0f // the range of the amplifier is 16 A, either sign
#define VARIANT_TRIP_MIN_A 2.0f

// Phases a, b, c: ePWM and its pads (A, B); the first one triggers the ADCs.
#define VARIANT_PWM                                                                                \
    { 0u, 1u, 2u }
#define VARIANT_PWM_PADS                                                                           \
    { 43u, 44u, 45u, 46u, 47u, 48u } // EPWM0_A .. EPWM2_B
// ADC and channel, and the comparator that has the same pin on both of its inputs.
#define VARIANT_CURRENTS                                                                           \
    {0u, 4u, 0u}, {1u, 4u, 2u}, {                                                                  \
        2u, 4u, 4u                                                                                 \
    } // ADC0_AIN4 with CMPSSB0, ADC1_AIN4 with CMPSSB2, ADC2_AIN4 with CMPSSB4
// The bus is converted after a current on the same ADC, so that its end is the end of all conversions.
#define VARIANT_BUS_ADC 0u
#define VARIANT_BUS_CHANNEL 0u // ADC0_AIN0

// The temperature is converted after a current on another ADC.
#define VARIANT_T_ADC 1u
#define VARIANT_T_CHANNEL 0u // ADC1_AIN0

#define VARIANT_ENABLE_GPIO 49u // pad EPWM3_A; high switches the gate driver on
#define VARIANT_FAULT_GPIO 50u  // pad EPWM3_B; active low
#define VARIANT_TX_PAD 28u      // UART0_TXD

#endif
