/// An AM263x with any inverter of six gate inputs, three low-side shunts with amplifiers biased to the
/// middle of the range, an enable and an active-low fault line. Figures are those of a 24 V, 10 A stage:
/// copy this file and enter your board's.
#ifndef LODESTAR_PORT_BOARD_VARIANT_H
#define LODESTAR_PORT_BOARD_VARIANT_H

#define VARIANT_F_PWM_Hz 20000u
#define VARIANT_DEAD_TIME_ns 300u
#define VARIANT_PRECHARGE_s 0.0f // a driver with a charge pump or a supply of its own

// Power stage.
#define VARIANT_V_BUS_V 24.0f
#define VARIANT_I_MAX_A 10.0f
#define VARIANT_V_DROP_V 0.0f
#define VARIANT_R_ON_Ohm 0.0f

// Shunt 5 mOhm, amplifier 20. A current into the motor pulls the low-side shunt below ground.
#define VARIANT_V_REF_V 3.2f // the converters' full scale with VREFHI of 1.8 V
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
#define VARIANT_T_GAIN_degC_count 0.0f                           // no temperature is measured
#define VARIANT_T_OFFSET_degC 0.0f
#define VARIANT_T_MAX_degC 0.0f // the core's default
#define VARIANT_SETTLE_ns 1700.0f
#define VARIANT_TRIP_MAX_A 14.0f // of 16 A that the amplifier can show, either sign
#define VARIANT_TRIP_MIN_A 2.0f

// Phases a, b, c: ePWM and its pads (A, B); the first one triggers the converters.
#define VARIANT_PWM                                                                                \
    { 0u, 1u, 2u }
#define VARIANT_PWM_PADS                                                                           \
    { 43u, 44u, 45u, 46u, 47u, 48u } // EPWM0_A .. EPWM2_B
// Converter and channel, and the comparator that has the same pin on both of its inputs.
#define VARIANT_CURRENTS                                                                           \
    {0u, 4u, 0u}, {1u, 4u, 2u}, {                                                                  \
        2u, 4u, 4u                                                                                 \
    } // ADC0_AIN4 with CMPSSB0, ADC1_AIN4 with CMPSSB2, ADC2_AIN4 with CMPSSB4
// After a current on the same converter, so its end is the end of all.
#define VARIANT_BUS_ADC 0u
#define VARIANT_BUS_CHANNEL 0u // ADC0_AIN0

#define VARIANT_ENABLE_GPIO 49u // pad EPWM3_A; high switches the gate driver on
#define VARIANT_FAULT_GPIO 50u  // pad EPWM3_B; active low
#define VARIANT_TX_PAD 28u      // UART0_TXD

#endif
