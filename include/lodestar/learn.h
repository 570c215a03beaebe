/// Learns Lq and the magnets' flux of a running motor, at speeds where signal injection and the EMF both give the
/// position: their difference is an error of Lq. For the main loop, about 500 times a second, with a drive whose
/// configuration has hfi.learn on and no field left open (lode_drive_design()):
///
///     lode_telemetry_t now;
///     if (lode_drive_telemetry(&drive, &now) && lode_learn_step(&learn, &learn_tuning, &now, 0.002f) &&
///         lode_drive_tuning_taken(&drive) && lode_learn_tune(&learn, &tuning[next], &config) == LODE_OK) {
///         (void)lode_drive_post_tuning(&drive, &tuning[next]);
///         next = 1 - next;
///     }
///
/// The result is `learn.now`. Store it for the next start. docs/theory/injection.md.
///
/// Together with adaptation.h, which then finds psi and Rs: lode_learn_design() with `psi` off, and lode_adaptation_post() in place
/// of lode_drive_post_tuning().
#ifndef LODESTAR_LEARN_H
#define LODESTAR_LEARN_H

#include "lodestar/drive.h"

#ifdef __cplusplus
extern "C" {
#endif

/// What is worth storing.
typedef struct {
    float Lq_H;   ///< at the currents at which it was learned
    float psi_Wb; ///< flux linkage of the magnets
    float
        confidence; ///< in Lq: 0: nothing was learned; towards 1 as one look after the other agrees
} lode_learned_t;

typedef struct {
    float Ld_H;
    lode_range_t Lq_H;   ///< what may be learned
    lode_range_t psi_Wb; ///< the same
    float omega_least;   ///< electrical speed from which on there is EMF enough for Lq
    float omega_psi;     ///< and for psi
    float i_least_A;     ///< q current from which on an error of Lq shows
    float droop_s2;      ///< by which the observer's amplitude falls with speed
    bool learns_psi;
} lode_learn_tuning_t;

typedef struct {
    lode_learned_t now;
    lode_learned_t used; ///< by the tuning last made
    float time_s;        ///< since the look began, its first part of which is waited for
    float iq2_A2;        ///< sums over the look
    float off_VsA;
    float psi_Wb;
    float looks;
    float psi_looks;
} lode_learn_t;

/// Limits: 0.3 to 3 times the Lq of `config` (more where less would be refused), 0.7 to 1.2 times its psi. Refuses what
/// lode_drive_tune() refuses, LODE_ERROR_HFI_LEARN where hfi.learn, or injection itself, is off, and LODE_ERROR_CHOICE.
/// `psi`: auto: on; off where the adaptation finds psi or Rs: it stays as in `config`.
lode_status_t lode_learn_design(lode_learn_tuning_t *tuning, const lode_drive_config_t *config,
                                lode_choice_t psi);

/// `stored`: from another time, NULL: none. Then as configured, and not believed. Values out of limits are clamped.
void lode_learn_begin(lode_learn_t *self, const lode_learn_tuning_t *tuning,
                      const lode_drive_config_t *config, const lode_learned_t *stored);

/// `dt_s` after the last time. True: there is something to make a tuning of. Where not both sources tell the
/// position, or current, speed or lock are too small, nothing is learned and nothing forgotten.
bool lode_learn_step(lode_learn_t *self, const lode_learn_tuning_t *tuning,
                     const lode_telemetry_t *telemetry, float dt_s);

/// Lq and the confidence in it into `telemetry->motor`: after lode_drive_telemetry(). (Of psi nothing says how sure it is;
/// where the adaptation finds it, lode_adaptation_tell() does.)
void lode_learn_tell(const lode_learn_t *self, lode_telemetry_t *telemetry);

/// The tuning of `config` with what was learned: motor, current control and injection go by it, all else stays. A
/// refused one leaves `tuning` alone.
lode_status_t lode_learn_tune(lode_learn_t *self, lode_drive_tuning_t *tuning,
                              const lode_drive_config_t *config);

#ifdef __cplusplus
}
#endif

#endif
