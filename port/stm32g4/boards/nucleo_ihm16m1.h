/// NUCLEO-G431RB with X-NUCLEO-IHM16M1: STSPIN830 driver, three shunts with amplifiers on the board,
/// over-current by the driver (EN/FAULT). 24 MHz crystal.
///
/// The driver has one PWM input and one enable input per phase: it generates the low sides and the dead time
/// itself. With its enable low a phase floats.
#ifndef LODESTAR_PORT_BOARD_VARIANT_H
#define LODESTAR_PORT_BOARD_VARIANT_H

// Clock and PWM.
#define VARIANT_HSE_Hz 24000000u
#define VARIANT_F_PWM_Hz 20000u
#define VARIANT_DEAD_TIME_ns 550u // the driver's own dead time; used only for the correction
#define VARIANT_LOW_SIDES false // hence no VARIANT_PRECHARGE_s: the driver has its own charge pump

// Power stage: 7 .. 45 V, 1.5 A effective.
#define VARIANT_V_BUS_V 12.0f
#define VARIANT_I_MAX_A 1.5f
#define VARIANT_V_DROP_V 0.0f
// High and low side of the STSPIN830 together are about 1 Ohm; the shunt in series with the low side counts for
// half of the time.
#define VARIANT_R_ON_Ohm (0.5f * (1.0f + VARIANT_SHUNT_Ohm))

#define VARIANT_V_REF_V 3.3f
#define VARIANT_COUNTS 4096.0f
#define VARIANT_SHUNT_Ohm 0.33f
#define VARIANT_AMPLIFIER 1.53f
#define VARIANT_I_GAIN_A_count                                                                     \
    (-VARIANT_V_REF_V / VARIANT_COUNTS / (VARIANT_SHUNT_Ohm * VARIANT_AMPLIFIER))
// The amplifiers' bias in ST's project; bring-up step 2 shows that of your board.
#define VARIANT_I_OFFSET_count 1934.0f
#define VARIANT_I_OFFSET_TOL_count 300.0f
#define VARIANT_V_BUS_GAIN_V_count                                                                 \
    (VARIANT_V_REF_V / VARIANT_COUNTS * (169.0f + 9.31f) / 9.31f) // 169 kOhm over 9.31 kOhm
// NTC on PC4, the linear approximation of ST's project: 579 mV at 25 degC, 27.4 mV/degC. The limit is our own
// conservative value.
#define VARIANT_T_V 0.579f // at VARIANT_T_degC
#define VARIANT_T_degC 25.0f
#define VARIANT_T_V_degC 0.0274f
#define VARIANT_T_MAX_degC 85.0f
#define VARIANT_T_GAIN_degC_count (VARIANT_V_REF_V / VARIANT_COUNTS / VARIANT_T_V_degC)
#define VARIANT_T_OFFSET_degC (VARIANT_T_degC - VARIANT_T_V / VARIANT_T_V_degC)
#define VARIANT_SETTLE_ns 2000.0f // a conservative value: check the amplifier's output with a scope

#define VARIANT_ADC1_RANKS                                                                         \
    { 12u, 15u, 15u } // i_b on PB1, i_c on PB0
#define VARIANT_ADC2_RANKS                                                                         \
    { 2u, 1u, 5u } // i_a on PA1, bus on PA0, NTC on PC4
#define VARIANT_COUNT_A ADC2->JDR1
#define VARIANT_COUNT_B ADC1->JDR1
#define VARIANT_COUNT_C ADC1->JDR2
#define VARIANT_COUNT_BUS ADC2->JDR2
#define VARIANT_COUNT_T ADC2->JDR3

#define VARIANT_PWM_PINS                                                                           \
    {GPIOA, 8u, 6u}, {GPIOA, 9u, 6u}, {                                                            \
        GPIOA, 10u, 6u                                                                             \
    }
#define VARIANT_ANALOG_PINS                                                                        \
    {GPIOA, 0u, 0u}, {GPIOA, 1u, 0u}, {GPIOB, 0u, 0u}, {GPIOB, 1u, 0u}, {                          \
        GPIOC, 4u, 0u                                                                              \
    }
#define VARIANT_TX_PIN                                                                             \
    { GPIOA, 2u, 7u } // USART2, the ST-LINK's virtual COM port

#define VARIANT_ENABLE_PINS                                                                        \
    {GPIOB, 13u, 0u}, {GPIOB, 14u, 0u}, {                                                          \
        GPIOB, 15u, 0u                                                                             \
    }
// EN/FAULT, active low. ST's field-oriented project has it on PA11, its six-step one on PB12; it is not known
// which of them the board's solder bridges connect, so both are break inputs. An unconnected one is pulled up.
#define VARIANT_BREAK_PIN                                                                          \
    { GPIOB, 12u, 6u } // TIM1_BKIN
#define VARIANT_BREAK2_PIN                                                                         \
    { GPIOA, 11u, 12u } // TIM1_BKIN2

#endif
