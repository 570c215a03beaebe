// What ST publishes for the B-G431B-ESC1, in its project and schematic; three figures are the port's own choice.
#define BOARD_I_MAX_A 20.0       // choice
#define BOARD_DEAD_TIME_s 800e-9 // choice: the L6387 has none worth counting on
#define BOARD_SETTLE_s                                                                             \
    2.8e-6                 // choice: dead time and ten time constants of an amplifier of 13 MHz/16
#define BOARD_R_ON_Ohm 0.0 // small beside any winding
#define BOARD_I_GAIN_A_count (-3.3 / 4096.0 / (0.003 * 9.14))
#define BOARD_I_OFFSET_count (2.058 / 3.3 * 4096.0) // 128.6 mV times 16
#define BOARD_BUS_V_count (3.3 / 4096.0 / 0.09626)
#define BOARD_T_GAIN_degC_count 0.03549 // 22.7 mV/degC
#define BOARD_T_OFFSET_degC (-21.5)     // 1055 mV at 25 degC
#define BOARD_T_MAX_degC 110.0
