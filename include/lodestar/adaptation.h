/// Adaptation while the drive runs: inertia, flux and resistance, estimated from speed, current and EMF.
/// For the main loop, called 100 to 1000 times a second; the interrupt has no part in it:
///
///     (void)lode_adaptation_step(&adaptation, &drive);
///
/// The result goes into a copy of the drive's tuning, which is posted. A tuning made by learn.h is posted through
/// here too, with lode_adaptation_post() in place of lode_drive_post_tuning(). J changes speed control and
/// feed-forward only, psi the torque that the references ask for, Rs the observer's voltage. All else stays as
/// designed, including the flux that FLUX and the lock are judged by (docs/adaptation.md).
///
/// Three phases; six: adaptation6.h.
#ifndef LODESTAR_ADAPTATION_H
#define LODESTAR_ADAPTATION_H

#include "lodestar/drive.h"

#ifdef __cplusplus
extern "C" {
#endif

/// LODE_AUTO: on.
typedef struct {
    lode_choice_t J;
    lode_choice_t psi;
    lode_choice_t Rs;
} lode_adaptation_config_t;

/// What an application may display, and keep across a reset.
typedef struct {
    lode_adapted_t J_kgm2; ///< 0.2 .. 5 times the configured one
    lode_adapted_t psi_Wb; ///< within 20 % of the configured one
    /// of the winding, within 50 % of the configured one: what the start has measured and what became of it
    lode_adapted_t Rs_Ohm;
} lode_adaptation_found_t;

/// A high-pass (washout) with two equal poles (O1).
typedef struct {
    float one;
    float two;
} lode_adaptation_filter_t;

/// What one change of the ramp's slope has shown (O2), (O3).
typedef struct {
    float energy;  ///< of the ramp
    float seen;    ///< correlation of ramp and acceleration
    float asked;   ///< of ramp and torque
    float torque2; ///< energy of the torque
    float acc2;    ///< of the acceleration
    float both;    ///< correlation of the two
} lode_adaptation_edge_t;

/// What is known of the motor, with three phases or six.
typedef struct {
    const lode_drive_tuning_t *base; ///< as commissioned, or posted since; of six phases both sets'
    const lode_drive_tuning_t *posted; ///< last, the same with what is in use; at first the base
    lode_motor_t motor;
    bool adapts_J;
    bool adapts_psi;
    bool adapts_Rs;
    bool runs; ///< the last call saw RUN, so that there are differences
    uint32_t steps;
    float lambda_rad_s; ///< both poles of the washout
    float torque_Nm;    ///< of the last call
    float quiet_s;      ///< since a tuning was posted
    lode_adaptation_filter_t by_torque;
    lode_adaptation_filter_t by_speed;
    lode_adaptation_filter_t by_ramp;
    lode_adaptation_edge_t edge; ///< under way
    float seen;                  ///< of the edges that agree with a constant inertia
    float asked;
    float other;     ///< inertia of the last edge that did not agree, over the configured one
    float spread;    ///< by which edges differed from what was found before, over that
    float psi_share; ///< beyond the configured flux, over it
    float Rs_share;  ///< the same of the resistance
    float variance_psi;
    float variance_Rs;
    float covariance;
    float J_used;   ///< in the posted tuning, over the configured one
    float psi_used; ///< as psi_share
    float Rs_used;  ///< as Rs_share
} lode_adaptation_machine_t;

/// Visible for static allocation; written by its functions only.
typedef struct {
    lode_adaptation_machine_t machine;
    lode_drive_tuning_t tuning[2]; ///< posted in turn
} lode_adaptation_t;

/// `tuning`: what the drive runs on, made for `motor`, whose omega_rated_rad_s must be given; both as
/// commissioned by the application, not as found here. `tuning` must stay. `stored`: what
/// lode_adaptation_found() said at another time, or NULL. LODE_OK, or why not; `self` is then unchanged.
lode_status_t lode_adaptation_init(lode_adaptation_t *self, const lode_adaptation_config_t *config,
                                   const lode_drive_tuning_t *tuning, const lode_motor_t *motor,
                                   const lode_adaptation_found_t *stored);

/// Evaluates the drive; true: a new tuning was posted. Calls need not be regular: time is the drive's own count of
/// periods. It pauses outside RUN, and while the drive runs on a tuning that did not come from here.
bool lode_adaptation_step(lode_adaptation_t *self, lode_drive_t *drive);

/// Makes `tuning`, which must stay, the drive's next one, with what was found. It must be made for the commissioned
/// motor; only Lq may differ. False: the last one is not taken yet, and nothing was done.
bool lode_adaptation_post(lode_adaptation_t *self, lode_drive_t *drive,
                          const lode_drive_tuning_t *tuning);

lode_adaptation_found_t lode_adaptation_found(const lode_adaptation_t *self);

/// The same into `telemetry->motor`, for logs, displays and the fault log: after lode_drive_telemetry().
void lode_adaptation_tell(const lode_adaptation_t *self, lode_telemetry_t *telemetry);

#ifdef __cplusplus
}
#endif

#endif
