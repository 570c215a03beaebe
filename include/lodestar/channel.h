/// Channels: the quantities of a drive that can be recorded, each as a float, and the choice of channels and rate
/// of a recorder.
#ifndef LODESTAR_CHANNEL_H
#define LODESTAR_CHANNEL_H

#include "lodestar/drive.h"

#ifdef __cplusplus
extern "C" {
#endif

/// The channels: enumerator, number, name in files, unit. Meaning and instant are those of the field in
/// lode_telemetry_t; the four in stator axes are the inputs of the estimator. The numbers appear in files and on
/// the wire, so none is ever changed or reused.
#define LODE_CHANNELS(ROW)                                                                         \
    ROW(MODE, 0, "mode", "")     /* lode_mode_t */                                                 \
    ROW(CHECK, 1, "check", "")   /* of the fault: lode_check_t, 0 none */                          \
    ROW(DUTY_A, 2, "duty_a", "") /* share of the period */                                         \
    ROW(DUTY_B, 3, "duty_b", "")                                                                   \
    ROW(DUTY_C, 4, "duty_c", "")                                                                   \
    ROW(ID, 5, "id_A", "A") /* in the frame of control */                                          \
    ROW(IQ, 6, "iq_A", "A")                                                                        \
    ROW(ID_REF, 7, "id_ref_A", "A")                                                                \
    ROW(IQ_REF, 8, "iq_ref_A", "A")                                                                \
    ROW(UD, 9, "ud_V", "V")                                                                        \
    ROW(UQ, 10, "uq_V", "V")                                                                       \
    ROW(V_BUS, 11, "v_bus_V", "V")                                                                 \
    ROW(TEMPERATURE, 12, "temperature_degC", "degC")                                               \
    ROW(THETA, 13, "theta_rad", "rad")             /* electrical, in -pi .. pi */                  \
    ROW(OMEGA, 14, "omega_rad_s", "rad/s")         /* electrical */                                \
    ROW(SPEED_REF, 15, "speed_ref_rad_s", "rad/s") /* mechanical */                                \
    ROW(LOAD_TORQUE, 16, "load_torque_Nm", "Nm")                                                   \
    ROW(LOCK, 17, "lock", "")          /* 0 .. 1 */                                                \
    ROW(E_ALPHA, 18, "e_alpha_V", "V") /* raw output of the EMF observer */                        \
    ROW(E_BETA, 19, "e_beta_V", "V")                                                               \
    ROW(FAULT_MEASURED, 20, "fault_measured", "of check") /* or of an attempt that failed */       \
    ROW(FAULT_LIMIT, 21, "fault_limit", "of check")                                                \
    ROW(I_ALPHA, 22, "i_alpha_A", "A") /* what the estimator has seen at t_k; 0: gates off */      \
    ROW(I_BETA, 23, "i_beta_A", "A")                                                               \
    ROW(U_ALPHA, 24, "u_alpha_V", "V") /* mean over [t_k, t_k+1): what it will see next */         \
    ROW(U_BETA, 25, "u_beta_V", "V")                                                               \
    ROW(START_STAGE, 26, "start_stage", "") /* lode_start_stage_t, 0 outside START */              \
    ROW(RETRIES, 27, "retries", "")         /* attempts of the start that have failed */           \
    ROW(CRITERION, 28, "criterion", "")     /* that the last one did not meet: lode_criterion_t */ \
    ROW(SIGNALS_CHECKED, 29, "signals_checked",                                                    \
        "")                         /* 1: the start's signal check has gone through */             \
    ROW(LIMITED, 30, "limited", "") /* bits LODE_LIMITED_... of lode_drive_limited() */

#define LODE_CHANNEL_ENUMERATOR(channel, number, name, unit) LODE_CHANNEL_##channel = (number),
typedef enum {
    LODE_CHANNELS(LODE_CHANNEL_ENUMERATOR) LODE_CHANNEL_COUNT ///< number of them, none itself
} lode_channel_t;
#undef LODE_CHANNEL_ENUMERATOR

/// Largest number of channels of one recorder.
#define LODE_CHANNELS_MAX 16

/// Channels of a recorder's row, and how often a row is taken.
typedef struct {
    float f_pwm_Hz;      ///< rate of the step, Hz, 1e3 .. 2e5
    uint16_t decimation; ///< control periods per row; 0: 1
    uint16_t count;      ///< channels used, 1 .. LODE_CHANNELS_MAX
    lode_channel_t channel[LODE_CHANNELS_MAX];
} lode_channels_config_t;

/// State of that selection.
typedef struct {
    uint16_t decimation;
    uint16_t wait; ///< periods until the next row
    uint16_t count;
    uint_least8_t channel[LODE_CHANNELS_MAX]; ///< lode_channel_t
} lode_channels_t;

/// Value of `channel` in the last control period of `drive`; 0 for an unknown number. For the interrupt, after
/// lode_drive_step().
float lode_channel_read(const lode_drive_t *drive, lode_channel_t channel);

/// The bits of `value` as an IEEE-754 single: sign, 8 bits of exponent, 23 bits of fraction, from the highest bit
/// down.
uint32_t lode_channel_bits(float value);

/// Checks `config` and begins. Errors: NULL, F_PWM, CHANNELS; `self` is then left alone.
lode_status_t lode_channels_init(lode_channels_t *self, const lode_channels_config_t *config);

/// Counts one control period. True: a row is due.
static inline bool lode_channels_due(lode_channels_t *self) {
    const bool due = self->wait == 0u;
    const uint16_t from = due ? self->decimation : self->wait;
    self->wait = (uint16_t)(from - 1u);
    return due;
}

/// Writes the bits of all channels to `row`, which has room for self->count words.
void lode_channels_row(const lode_channels_t *self, const lode_drive_t *drive, uint32_t *row);

#ifdef __cplusplus
}
#endif

#endif
