/// The drives that the budget counts, for the host that records them and for the image that replays
/// what was recorded. Only the public interface of the drive is used.
#ifndef BENCH_DRIVES_H
#define BENCH_DRIVES_H

#include "lodestar/lodestar.h"

/// Operating point of every steady case.
#define BENCH_POLE_PAIRS 4.0f
#define BENCH_F_PWM_Hz 1.0e4f
#define BENCH_V_BUS_V 48.0f
#define BENCH_RS_Ohm 0.05f
#define BENCH_L_H 1.0e-4f
#define BENCH_LXY_H (0.5f * BENCH_L_H) // with six phases; assumed
#define BENCH_PSI_Wb 0.02f
#define BENCH_J_kgm2 1.0e-4f
#define BENCH_OMEGA_rad_s 471.0f // electrical
#define BENCH_IQ_A 10.0f
#define BENCH_DEAD_TIME_s 1.0e-6f
/// Phase current below which the effect of the dead time fades.
#define BENCH_I_DEAD_A 0.5f

/// The board: 12-bit ADCs.
#define BENCH_I_OFFSET_count 2048.0f
#define BENCH_I_GAIN_A_count 0.02f
#define BENCH_V_GAIN_V_count 0.02f
#define BENCH_STAMP_PER_PERIOD 1000u

/// The same of every case with signal injection.
#define BENCH_OMEGA_LOW_rad_s 60.0f

/// Periods in which a drive calibrates, starts, hands over and settles.
#define BENCH_SETTLE 2000
/// The same for BENCH_INJECTING, whose axis and polarity take 160 ms: the largest of all.
#define BENCH_SETTLE_INJECTING 2600
/// The same for BENCH_RISE: the calibration.
#define BENCH_SETTLE_RISE 140
/// The same for BENCH_START: the counted ones hold the last of the standstill, with the call that takes over
/// what was measured, the ramp and the hand-over.
#define BENCH_SETTLE_START 1920
/// Periods that are counted. After them the call number wraps around, and the record with a jump.
#define BENCH_ROWS 512

typedef enum {
    BENCH_STEADY,    ///< RUN at the operating point
    BENCH_RISE,      ///< current vector at standstill: rise, resistance and dead time measured
    BENCH_START,     ///< the same further on: ramp, hand-over, RUN
    BENCH_SATURATED, ///< RUN at the current limit while the bus falls to the voltage limit
    BENCH_INJECTING, ///< RUN at the torque of the operating point, so slow that a signal is injected
    BENCH_FAULT,     ///< RUN, over-voltage, FAULT
    BENCH_OFF        ///< gates off
} bench_scene_t;

/// Of the salient cases, and of all on a board.
#define BENCH_LD_SALIENT_H (0.7f * BENCH_L_H)
/// The board cases, as port/stm32g4 configures a drive: a timer of 170 MHz that counts up and down, and
/// low-side amplifiers that need 2.6 us of the period's ends (B-G431B-ESC1).
#define BENCH_PWM_TICKS 8500.0f
#define BENCH_DUTY_MAX (1.0f - 2.0f * 2.6e-6f * BENCH_F_PWM_Hz)

/// A build without injection refuses them: a test that compares both leaves them out.
#ifdef BENCH_WITHOUT_INJECTING
#define BENCH_INJECTING_CASES(X)
#else
#define BENCH_INJECTING_CASES(X)                                                                   \
    X(injecting, INJECTING, C_LESO, LESO, NOTCH, SALIENT)                                          \
    X(board_injecting, INJECTING, C_LESO, LESO, NOTCH, BOARD)
#endif

/// `enhanced` without one of the plausibility checks, for what each costs.
#ifdef BENCH_CHECKS
#define BENCH_CHECKS_CASES(X)                                                                      \
    X(without_stuck, STEADY, C_LESO, LESO, NO_STUCK, ROUND)                                        \
    X(without_gain, STEADY, C_LESO, LESO, NO_GAIN, ROUND)                                          \
    X(without_half_waves, STEADY, C_LESO, LESO, NO_HALF_WAVES, ROUND)                              \
    X(without_sum, STEADY, C_LESO, LESO, NO_SUM, ROUND)                                            \
    X(without_overload, STEADY, C_LESO, LESO, NO_OVERLOAD, ROUND)                                  \
    X(without_flux, STEADY, C_LESO, LESO, NO_FLUX, ROUND)
#else
#define BENCH_CHECKS_CASES(X)
#endif

/// name, scene, EMF observer, PLL, options: notch at 6 w / everything that costs / speed control as fast
/// as in every fourth period / the notch, but no look at the currents' plausibility, or not at one thing, machine: without or
/// with saliency / with it on a board / there with MTPA and field weakening
#define BENCH_CASES(X)                                                                             \
    X(c_leso_qpll, STEADY, C_LESO, QPLL, PLAIN, ROUND)                                             \
    X(enhanced, STEADY, C_LESO, LESO, NOTCH, ROUND)                                                \
    X(all_options, STEADY, FA_MULTI, LESO, ALL, ROUND)                                             \
    X(salient_c_leso_qpll, STEADY, C_LESO, QPLL, PLAIN, SALIENT)                                   \
    X(salient_enhanced, STEADY, C_LESO, LESO, NOTCH, SALIENT)                                      \
    X(board_c_leso_qpll, STEADY, C_LESO, QPLL, PLAIN, BOARD)                                       \
    X(board_enhanced, STEADY, C_LESO, LESO, NOTCH, BOARD)                                          \
    X(board_mtpa, STEADY, C_LESO, LESO, NOTCH, MTPA)                                               \
    X(unwatched, STEADY, C_LESO, LESO, UNWATCHED, ROUND)                                           \
    X(board_unwatched, STEADY, C_LESO, LESO, UNWATCHED, BOARD)                                     \
    BENCH_CHECKS_CASES(X)                                                                          \
    BENCH_INJECTING_CASES(X)                                                                       \
    X(fast_speed, STEADY, C_LESO, LESO, FAST, ROUND)                                               \
    X(rise, RISE, C_LESO, LESO, NOTCH, ROUND)                                                      \
    X(start, START, C_LESO, LESO, NOTCH, ROUND)                                                    \
    X(saturated, SATURATED, C_LESO, LESO, NOTCH, ROUND)                                            \
    X(fault, FAULT, C_LESO, LESO, NOTCH, ROUND)                                                    \
    X(off, OFF, C_LESO, LESO, NOTCH, ROUND)

#define BENCH_ENUMERATOR(name, ...) BENCH_##name,
enum {
    BENCH_CASES(BENCH_ENUMERATOR)
// Each EMF observer of the table with the LESO-QPLL: STEADY, PLAIN.
#define LODE_OBSERVER(ID, id, name, STEP, vectors, numbers) BENCH_##id##_leso_qpll,
#include "lodestar/observers.def"
#undef LODE_OBSERVER
        BENCH_CASE_COUNT
};

bench_scene_t bench_scene(int32_t number);

/// Periods before the first counted one.
int32_t bench_settle(int32_t number);

/// Electrical speed that a case is asked for while it settles.
float bench_omega_rad_s(int32_t number);

/// Configuration of a case; fields left open are computed by init.
lode_drive_config_t bench_config(int32_t number);

extern lode_drive_t bench_drive[BENCH_CASE_COUNT];

/// Initialises drive `number` and posts its first command. False: refused.
bool bench_begin(int32_t number);

/// To be called between the settling periods and the counted ones.
void bench_settled(int32_t number);

/// Where a drive must be after so many counted calls.
typedef struct {
    uint32_t digest; ///< of the last output: the same to the bit on every machine
    float theta_rad; ///< true rotor angle
    lode_mode_t mode;
} bench_truth_t;

/// The duties and the gates of one period as one number.
uint32_t bench_digest(lode_drive_out_t out);

/// The estimate of a drive in RUN is good: lock above 0.9, angle within 0.1 rad of the rotor's, and in
/// the steady cases speed within 1 % of the operating point. BENCH_SATURATED, which changes speed as
/// fast as it can: 0.7 and 0.3 rad. BENCH_INJECTING, whose lock has the ADC's noise in it: 0.7.
bool bench_estimate_is_good(int32_t number, const lode_telemetry_t *telemetry, float theta_rad);

#endif
