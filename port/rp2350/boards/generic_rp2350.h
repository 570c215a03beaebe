/// An RP2350 with a gate driver that has one PWM input per half bridge and switches on the high or the low
/// side, never both. Two low-side shunts with amplifiers around mid-range, and the bus voltage: three ADC
/// inputs, as many as a Pico 2 has. The values are those of a 24 V, 5 A stage: copy this file and enter yours.
#ifndef LODESTAR_PORT_BOARD_VARIANT_H
#define LODESTAR_PORT_BOARD_VARIANT_H

// This chip has neither dead time nor a break input. Declare the functions of your gate driver, from its data
// sheet and its setup on your board; the port builds only with all three. It also needs a charge
// pump: with one input per half bridge bootstrap capacitors cannot be charged before the start.
//   INTERLOCK     the two switches of a leg are never on together, whatever its input
//   DEAD_TIME     inserted by the driver
//   LATCHED_TRIP  over-current switches all six switches off until a reset
#define VARIANT_DRIVER_INTERLOCK 1
#define VARIANT_DRIVER_DEAD_TIME 1
#define VARIANT_DRIVER_LATCHED_TRIP 1
#define VARIANT_DEAD_TIME_ns 400u // dead time of the driver; used only for the correction

#define VARIANT_XOSC_Hz 12000000u
#define VARIANT_F_PWM_Hz 20000u

// Power stage.
#define VARIANT_V_BUS_V 24.0f
#define VARIANT_I_MAX_A 5.0f
#define VARIANT_V_DROP_V 0.0f
#define VARIANT_R_ON_Ohm 0.0f

// Shunt 10 mOhm, amplifier gain 20. A current into the motor pulls the low-side shunt below ground.
#define VARIANT_V_REF_V 3.3f
#define VARIANT_COUNTS 4096.0f
#define VARIANT_SHUNT_Ohm 0.010f
#define VARIANT_AMPLIFIER 20.0f
#define VARIANT_I_GAIN_A_count                                                                     \
    (-VARIANT_V_REF_V / VARIANT_COUNTS / (VARIANT_SHUNT_Ohm * VARIANT_AMPLIFIER))
#define VARIANT_I_OFFSET_count 2048.0f
#define VARIANT_I_OFFSET_TOL_count 200.0f
#define VARIANT_V_BUS_GAIN_V_count                                                                 \
    (VARIANT_V_REF_V / VARIANT_COUNTS * (82.0f + 4.99f) / 4.99f) // 82 kOhm over 4.99 kOhm
// No input is left for a temperature; the driver has its own limit.
#define VARIANT_T_GAIN_degC_count 0.0f
#define VARIANT_T_OFFSET_degC 0.0f
#define VARIANT_T_MAX_degC 0.0f // 0: the default of the library
#define VARIANT_SETTLE_ns 1500.0f

// Two sensors and the bus on ADC0 .. ADC2 (GPIO26 .. 28), or three and the bus if ADC3 (GPIO29) is free.
#ifndef VARIANT_SENSING
#define VARIANT_SENSING PORT_LOW_SIDE_TWO
#endif

// Inputs of phases a, b, c: even pins, of three different slices (0 .. 7, two pins each).
#define VARIANT_PWM_GPIOS                                                                          \
    { 0u, 2u, 4u }
#define VARIANT_ENABLE_GPIO 6u // low: all half bridges float; with a pull-down on the board
#define VARIANT_RESET_GPIO 7u  // a low pulse clears the driver's latch; high: awake
#define VARIANT_FAULT_GPIO 8u  // active low, open drain
#define VARIANT_TX_GPIO 12u    // UART0

#endif
