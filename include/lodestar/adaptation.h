/// Adaptation in operation: estimates inertia, flux and resistance from speed, current and EMF. For the main loop,
/// called 100 to 1000 times per second; nothing runs in the interrupt:
///
///     (void)lode_adaptation_step(&adaptation, &drive);
///
/// The results go into a copy of the drive's tuning, which is posted. Tunings made by learn.h go through here too, with
/// lode_adaptation_post() instead of lode_drive_post_tuning(). J acts on speed control, its feed-forward and the
/// acceleration that the PLL expects of a torque, psi on the current for a torque, Rs on the observer's voltage.
/// Everything else keeps its design value, including the flux by which
/// FLUX and the lock are judged (docs/adaptation.md).
///
/// For three phases; six phases: adaptation6.h.
#ifndef LODESTAR_ADAPTATION_H
#define LODESTAR_ADAPTATION_H

#include "lodestar/drive.h"

#ifdef __cplusplus
extern "C" {
#endif

/// What is adapted. LODE_AUTO: on.
typedef struct {
    lode_choice_t J;
    lode_choice_t psi;
    lode_choice_t Rs;
} lode_adaptation_config_t;

/// Results, for display and for storage across a reset.
typedef struct {
    lode_adapted_t J_kgm2; ///< within 0.2 .. 5 times the configured value
    lode_adapted_t psi_Wb; ///< within 20 % of the configured value
    /// of the winding, within 50 % of the configured value: as measured by the start, and followed since
    lode_adapted_t Rs_Ohm;
} lode_adaptation_found_t;

/// High-pass (washout) with two equal poles (O1).
typedef struct {
    float one;
    float two;
} lode_adaptation_filter_t;

/// Sums over one edge, a change of the ramp's slope (O2), (O3).
typedef struct {
    float energy;      ///< energy of the ramp
    float ramp_acc;    ///< correlation of ramp and acceleration
    float ramp_torque; ///< correlation of ramp and torque
    float torque2;     ///< energy of the torque
    float acc2;        ///< energy of the acceleration
    float torque_acc;  ///< correlation of torque and acceleration
} lode_adaptation_edge_t;

/// Everything that is known about the motor, with three phases or six. "Share": relative to the configured value.
typedef struct {
    const lode_drive_tuning_t *base; ///< as commissioned or posted later; six phases: of both sets
    const lode_drive_tuning_t *posted; ///< last one posted: the base with the values in use
    lode_motor_t motor;
    bool adapts_J;
    bool adapts_psi;
    bool adapts_Rs;
    bool runs;                          ///< the last call was in RUN, so differences exist
    uint32_t steps;                     ///< lode_drive_t.steps at the last call
    float lambda_rad_s;                 ///< both poles of the washout
    float torque_Nm;                    ///< torque at the last call
    float quiet_s;                      ///< time since a tuning was posted
    lode_adaptation_filter_t by_torque; ///< washout of the torque
    lode_adaptation_filter_t by_speed;  ///< washout of the speed
    lode_adaptation_filter_t by_ramp;   ///< washout of the ramp
    lode_adaptation_edge_t edge;        ///< present edge
    float ramp_acc;                     ///< mean over the edges that agree on the inertia (O3)
    float ramp_torque;                  ///< the same for the torque
    float other;                        ///< inertia of the last edge that disagreed, as a share
    float spread;    ///< mean deviation of the edges from the mean before them, as a share
    float psi_share; ///< flux beyond the configured one, as a share
    float Rs_share;  ///< resistance beyond the configured one, as a share
    float variance_psi;
    float variance_Rs;
    float covariance;
    float J_used;   ///< inertia in the posted tuning, over the configured one
    float psi_used; ///< flux in the posted tuning, as psi_share
    float Rs_used;  ///< resistance in the posted tuning, as Rs_share
} lode_adaptation_machine_t;

/// The members are visible for static allocation; only the functions below write them.
typedef struct {
    lode_adaptation_machine_t machine;
    lode_drive_tuning_t tuning[2]; ///< used in turn for posting
} lode_adaptation_t;

/// `tuning`: the one that the drive runs on, made for `motor`; it must not change afterwards. `motor`: with
/// omega_rated_rad_s given. Both are those that the application has commissioned, not results of the adaptation.
/// `stored`: an earlier result of lode_adaptation_found(), or NULL. Returns LODE_OK or the reason for refusing;
/// `self` is then left alone.
lode_status_t lode_adaptation_init(lode_adaptation_t *self, const lode_adaptation_config_t *config,
                                   const lode_drive_tuning_t *tuning, const lode_motor_t *motor,
                                   const lode_adaptation_found_t *stored);

/// One call from the main loop. True: a new tuning was posted. Calls need not be regular, because the drive's count
/// of periods is the time base. Pauses outside RUN, and while the drive runs on a tuning that was not posted from
/// here.
bool lode_adaptation_step(lode_adaptation_t *self, lode_drive_t *drive);

/// Posts a copy of `tuning`, which must not change afterwards, with the results in it. It must have been made for
/// the commissioned motor; only Lq may differ. False: the drive has not taken the last one yet, and nothing was
/// posted.
bool lode_adaptation_post(lode_adaptation_t *self, lode_drive_t *drive,
                          const lode_drive_tuning_t *tuning);

/// The present results.
lode_adaptation_found_t lode_adaptation_found(const lode_adaptation_t *self);

/// Writes the same to `telemetry->motor`, for logs, displays and the fault log. After lode_drive_telemetry().
void lode_adaptation_telemetry(const lode_adaptation_t *self, lode_telemetry_t *telemetry);

#ifdef __cplusplus
}
#endif

#endif
