/// Learns Lq and the magnets' flux of a running motor, at speeds at which both signal injection and the EMF give
/// the position: the difference of the two comes from an error of Lq. For the main loop, about 500 times per
/// second. The configuration of the drive must have hfi.learn on and every field completed (lode_drive_design()):
///
///     lode_telemetry_t now;
///     if (lode_drive_telemetry(&drive, &now) && lode_learn_step(&learn, &learn_tuning, &now, 0.002f) &&
///         lode_drive_tuning_taken(&drive) && lode_learn_tune(&learn, &tuning[next], &config) == LODE_OK) {
///         (void)lode_drive_post_tuning(&drive, &tuning[next]);
///         next = 1 - next;
///     }
///
/// The result is `learn.now`; store it for the next start. docs/theory/injection.md.
///
/// Together with adaptation.h, which then estimates psi and Rs: call lode_learn_design() with `psi` off, and
/// lode_adaptation_post() instead of lode_drive_post_tuning().
#ifndef LODESTAR_LEARN_H
#define LODESTAR_LEARN_H

#include "lodestar/drive.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Result, to be stored.
typedef struct {
    float Lq_H;   ///< valid near the currents at which it was learned
    float psi_Wb; ///< flux linkage of the magnets
    /// of Lq, 0: nothing has been learned; approaches 1 while successive results agree
    float confidence;
} lode_learned_t;

/// Limits of the learning. Speeds are electrical.
typedef struct {
    float Ld_H;
    lode_range_t Lq_H;   ///< permitted range
    lode_range_t psi_Wb; ///< permitted range
    float omega_least;   ///< least speed for Lq: below it there is too little EMF
    float omega_psi;     ///< least speed for psi
    float i_least_A;     ///< least q current: below it an error of Lq cannot be seen
    float droop_s2;      ///< fall of the observer's amplitude with speed, as 1/(1 + droop w^2)
    bool learns_psi;     ///< psi is learned too
} lode_learn_tuning_t;

/// State of the learning.
typedef struct {
    lode_learned_t now;
    lode_learned_t used; ///< values in the tuning made last
    float time_s; ///< time since the present measurement began; the first part is for settling
    float iq2_A2; ///< sums over the measurement, as the next ones
    float off_VsA;
    float psi_Wb;
    float samples;
    float psi_samples;
} lode_learn_t;

/// Derives the limits: 0.3 to 3 times the Lq of `config` (a higher lower limit if less would be refused), 0.7 to
/// 1.2 times its psi. `psi`: auto: on; off if the adaptation estimates psi or Rs: psi then stays as in `config`.
/// Errors: NULL; CHOICE; HFI_LEARN if hfi.learn or injection is off; those of lode_drive_tune().
lode_status_t lode_learn_design(lode_learn_tuning_t *tuning, const lode_drive_config_t *config,
                                lode_choice_t psi);

/// Begins from `stored`, an earlier result. If that is NULL or outside the limits, it begins from `config` with
/// confidence 0.
void lode_learn_begin(lode_learn_t *self, const lode_learn_tuning_t *tuning,
                      const lode_drive_config_t *config, const lode_learned_t *stored);

/// One call from the main loop, `dt_s` after the last one. True: there are new values for a tuning. While one of
/// the two sources is missing, or current, speed or lock are too small, nothing is learned and nothing forgotten.
bool lode_learn_step(lode_learn_t *self, const lode_learn_tuning_t *tuning,
                     const lode_telemetry_t *telemetry, float dt_s);

/// Writes Lq and its confidence to `telemetry->motor`, after lode_drive_telemetry(). (The confidence of psi is not
/// known; if the adaptation estimates psi, lode_adaptation_telemetry() writes it.)
void lode_learn_telemetry(const lode_learn_t *self, lode_telemetry_t *telemetry);

/// Makes the tuning for `config` with the learned values. They act on motor, current control and injection;
/// everything else stays. On any error `tuning` is left alone.
lode_status_t lode_learn_tune(lode_learn_t *self, lode_drive_tuning_t *tuning,
                              const lode_drive_config_t *config);

#ifdef __cplusplus
}
#endif

#endif
