/// An STM32H743 on a board of your own: half-bridge drivers with six inputs, three low-side shunts with
/// external amplifiers around mid-range, a fault output of the driver, 8 MHz crystal. Change what differs;
/// every value is an example.
#ifndef LODESTAR_PORT_BOARD_VARIANT_H
#define LODESTAR_PORT_BOARD_VARIANT_H

#define VARIANT_HSE_Hz 8000000u // 0: no crystal, the 64 MHz RC oscillator instead
#define VARIANT_F_PWM_Hz 20000u
#define VARIANT_DEAD_TIME_ns 500u
#define VARIANT_LOW_SIDES true
#define VARIANT_PRECHARGE_s 10.0e-3f // of bootstrap capacitors; 0: none

#define VARIANT_V_BUS_V 24.0f
#define VARIANT_I_MAX_A 20.0f
#define VARIANT_V_DROP_V 0.0f
#define VARIANT_R_ON_Ohm 0.0f

#define VARIANT_V_REF_V 3.3f
#define VARIANT_COUNTS 4096.0f
#define VARIANT_SHUNT_Ohm 0.001f
#define VARIANT_AMPLIFIER 20.0f
// Negative: a current into the motor pulls the low-side shunt below ground.
#define VARIANT_I_GAIN_A_count                                                                     \
    (-VARIANT_V_REF_V / VARIANT_COUNTS / (VARIANT_SHUNT_Ohm * VARIANT_AMPLIFIER))
#define VARIANT_I_OFFSET_count 2048.0f
#define VARIANT_I_OFFSET_TOL_count 200.0f
#define VARIANT_V_BUS_GAIN_V_count                                                                 \
    (VARIANT_V_REF_V / VARIANT_COUNTS * (39.0f + 2.2f) / 2.2f) // 39 kOhm over 2.2 kOhm
// NTC of 10 kOhm and B = 3435 K between the ADC's input and ground, 10 kOhm up to the reference; the
// points are those of the B equation. Enter the table of your data sheet.
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
#define VARIANT_SETTLE_ns 2000.0f

#ifndef VARIANT_SENSING // two shunts, or sensors in the phases (whose gain is positive): figures.h
#define VARIANT_SENSING PORT_LOW_SIDE_THREE
#endif
// With sensors in the phases the drive may be called at both turning points: #define VARIANT_DOUBLE_UPDATE true

// Rank 1 of both is sampled at t_k, rank 2 0.6 us later.
#define VARIANT_ADC1_RANKS                                                                         \
    { 10u, 4u, 5u } // i_a on PC0, i_c on PC4, temperature on PB1
#define VARIANT_ADC2_RANKS                                                                         \
    { 11u, 8u, 8u } // i_b on PC1, bus on PC5 twice
#define VARIANT_COUNT_A ADC1->JDR1
#define VARIANT_COUNT_B ADC2->JDR1
#define VARIANT_COUNT_C ADC1->JDR2
#define VARIANT_COUNT_BUS ADC2->JDR2
#define VARIANT_COUNT_T ADC1->JDR3

#define VARIANT_PWM_PINS                                                                           \
    {GPIOA, 8u, 1u}, {GPIOA, 9u, 1u}, {GPIOA, 10u, 1u}, {GPIOB, 13u, 1u}, {GPIOB, 14u, 1u}, {      \
        GPIOB, 15u, 1u                                                                             \
    }
#define VARIANT_ANALOG_PINS                                                                        \
    {GPIOC, 0u, 0u}, {GPIOC, 1u, 0u}, {GPIOC, 4u, 0u}, {GPIOC, 5u, 0u}, {                          \
        GPIOB, 1u, 0u                                                                              \
    }
#define VARIANT_BREAK_PIN                                                                          \
    { GPIOB, 12u, 1u } // the driver's fault output, active low, on TIM1_BKIN
#define VARIANT_TX_PIN                                                                             \
    { GPIOB, 10u, 7u } // USART3

#endif
