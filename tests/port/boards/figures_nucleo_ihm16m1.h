// What ST publishes for the X-NUCLEO-IHM16M1 and its STSPIN830; two figures are the port's own choice.
#define BOARD_I_MAX_A 1.5
#define BOARD_DEAD_TIME_s 550e-9
#define BOARD_SETTLE_s 2.0e-6 // choice
#define BOARD_R_ON_Ohm 0.665  // half of: high and low side 1 Ohm, shunt 0.33 Ohm
#define BOARD_I_GAIN_A_count (-3.3 / 4096.0 / (0.33 * 1.53))
#define BOARD_I_OFFSET_count 1934.0
#define BOARD_BUS_V_count (3.3 / 4096.0 / 0.05221)
#define BOARD_T_GAIN_degC_count (3.3 / 4096.0 / 0.0274)
#define BOARD_T_OFFSET_degC (25.0 - 0.579 / 0.0274)
#define BOARD_T_MAX_degC 85.0 // choice
