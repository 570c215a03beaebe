/// ST B-G431B-ESC1: STM32G431CB, L6387 gate drivers, three low-side shunts into the chip's own
/// operational amplifiers, over-current by the chip's own comparators. 8 MHz crystal.
#ifndef LODESTAR_PORT_BOARD_VARIANT_H
#define LODESTAR_PORT_BOARD_VARIANT_H

// Clock and PWM.
#define VARIANT_HSE_Hz 8000000u // 0: no crystal, the 16 MHz RC oscillator instead
#define VARIANT_F_PWM_Hz 20000u
#define VARIANT_DEAD_TIME_ns 800u // the L6387's own dead time (320 ns) is not sufficient
#define VARIANT_LOW_SIDES true
// Bootstrap capacitors of the L6387, charged through about 125 Ohm inside it while a low side is on: five time
// constants of 1 uF are 0.6 ms, and a fifth of 10 ms is 2 ms. The capacitance on the board is not known.
#define VARIANT_PRECHARGE_s 10.0e-3f

// Power stage. Up to 6S LiPo.
#define VARIANT_V_BUS_V 24.0f
#define VARIANT_I_MAX_A 20.0f
#define VARIANT_V_DROP_V 0.0f
#define VARIANT_R_ON_Ohm 0.0f

// Shunt 3 mOhm; 1.5 kOhm against 22 kOhm || 2.2 kOhm passes 4/7 of the voltage, and the amplifier has a gain of 16. A
// current into the motor pulls the low-side shunt below ground: negative gain.
#define VARIANT_V_REF_V 3.3f
#define VARIANT_COUNTS 4096.0f
#define VARIANT_SHUNT_Ohm 0.003f
#define VARIANT_DIVIDER (4.0f / 7.0f)
#define VARIANT_AMPLIFIER 16.0f
#define VARIANT_I_GAIN_A_count                                                                     \
    (-VARIANT_V_REF_V / VARIANT_COUNTS / (VARIANT_SHUNT_Ohm * VARIANT_DIVIDER * VARIANT_AMPLIFIER))
// The same network lifts the input by 3.3 V * (1.5 || 2.2)/(22 + 1.5 || 2.2).
#define VARIANT_BIAS_V 0.1286f
#define VARIANT_I_OFFSET_count                                                                     \
    (VARIANT_BIAS_V * VARIANT_AMPLIFIER / VARIANT_V_REF_V * VARIANT_COUNTS)
#define VARIANT_I_OFFSET_TOL_count 300.0f // resistors of 1 % and the amplifier's offset, times 16
#define VARIANT_V_BUS_GAIN_V_count                                                                 \
    (VARIANT_V_REF_V / VARIANT_COUNTS * (169.0f + 18.0f) / 18.0f) // 169 kOhm over 18 kOhm
// NTC on PB14, the linear approximation and the limit of ST's project for this board: 1055 mV at 25 degC, 22.7
// mV/degC. An NTC is not linear: far from 25 degC the result is only an order of magnitude.
#define VARIANT_T_V 1.055f // at VARIANT_T_degC
#define VARIANT_T_degC 25.0f
#define VARIANT_T_V_degC 0.0227f
#define VARIANT_T_MAX_degC 110.0f
#define VARIANT_T_GAIN_degC_count (VARIANT_V_REF_V / VARIANT_COUNTS / VARIANT_T_V_degC)
#define VARIANT_T_OFFSET_degC (VARIANT_T_degC - VARIANT_T_V / VARIANT_T_V_degC)
// Dead time, then ten time constants of an amplifier with 13 MHz / 16, a typical value.
#define VARIANT_SETTLE_ns 2800.0f

// ADCs. Rank 1 of both is sampled at t_k, rank 2 some 0.45 us later.
#define VARIANT_ADC1_RANKS                                                                         \
    { 3u, 12u, 5u } // i_a on PA2, i_c on PB1, NTC on PB14
#define VARIANT_ADC2_RANKS                                                                         \
    { 3u, 1u, 1u } // i_b on PA6, bus on PA0 twice
#define VARIANT_COUNT_A ADC1->JDR1
#define VARIANT_COUNT_B ADC2->JDR1
#define VARIANT_COUNT_C ADC1->JDR2
#define VARIANT_COUNT_BUS ADC2->JDR2
#define VARIANT_COUNT_T ADC1->JDR3

// Pins: port, number, alternate function.
#define VARIANT_PWM_PINS                                                                           \
    {GPIOA, 8u, 6u}, {GPIOA, 9u, 6u}, {GPIOA, 10u, 6u}, {GPIOC, 13u, 4u}, {GPIOA, 12u, 6u}, {      \
        GPIOB, 15u, 4u                                                                             \
    }
#define VARIANT_ANALOG_PINS                                                                        \
    {GPIOA, 0u, 0u}, {GPIOA, 1u, 0u}, {GPIOA, 2u, 0u}, {GPIOA, 3u, 0u}, {GPIOA, 5u, 0u},           \
        {GPIOA, 6u, 0u}, {GPIOA, 7u, 0u}, {GPIOB, 0u, 0u}, {GPIOB, 1u, 0u}, {GPIOB, 2u, 0u}, {     \
        GPIOB, 14u, 0u                                                                             \
    }
#define VARIANT_TX_PIN                                                                             \
    { GPIOB, 3u, 7u } // USART2, the ST-LINK's virtual COM port

// Over-current: comparators 1, 2 and 4 on the amplifiers' inputs against DAC3. They detect only a current that
// flows back into the low side. A current that flows out returns through the other two phases, and the larger
// one of these is at least half of it. So a threshold of x acts between x and 2 x. This chip has no comparator
// left for the other sign; the drive's own trip covers both.
// Below this minimum the offset of a comparator, some mV at 1.7 mV/A, would dominate.
#define VARIANT_INTERNAL_ANALOG 1
#define VARIANT_TRIP_MAX_A 36.0f
#define VARIANT_TRIP_MIN_A 9.0f
#define VARIANT_TRIP_V(i_A) (VARIANT_BIAS_V + (i_A)*VARIANT_SHUNT_Ohm * VARIANT_DIVIDER)

#endif
