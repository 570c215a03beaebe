// Functions that the files of the drive share: drive.c has the steps' common parts, drive_config.c design and tuning,
// drive_watch.c the rare cases of the checks.
#ifndef LODE_DRIVE_PARTS_H
#define LODE_DRIVE_PARTS_H

#include "lodestar/drive.h"

// In drive_config.c. Checks the values that the design functions divide by.
lode_status_t lode_drive_check_given(const lode_drive_config_t *config);
// Default of current.voltage_use; `sense` must be designed already.
float lode_drive_voltage_use(const lode_drive_config_t *config);
// Tunes the signal check for the inductances of `motor`.
lode_status_t lode_drive_tune_signal_check(lode_drive_tuning_t *t, const lode_drive_config_t *c,
                                           const lode_motor_t *motor, const lode_fly_tuning_t *fly);

// In drive.c. Tells the interrupt that something is posted.
void lode_drive_notify(lode_drive_t *self);
// For duties beyond lode_sense_tuning_t.duty_max: updates `omitted` of their set. False: the duties are invalid, and the
// drive is in FAULT.
bool lode_drive_accept(lode_drive_t *self, uint_least8_t *omitted, const lode_abc_t *duty);
// Speed control where it runs more than once per round. Comes before current control.
void lode_drive_fast_speed(lode_drive_t *self);
// Share of the start current of the hand-over that remains at the next call of speed control.
float lode_drive_faded(const lode_drive_t *self);
// Target of speed control with a sensor, or for torque control.
float lode_drive_other_target(lode_drive_t *self, float omega_rad_s, float load_Nm);
#ifndef LODE_WITHOUT_OPTIMAL_REFERENCES
// References with MTPA, field weakening, a bus fade or a saturating q axis.
void lode_drive_optimal_references(lode_drive_t *self);
// With a saturating q axis. The first removes the EMF of the lacking flux from the period up to t_k (E31). The second renews
// the lag; as long as (E31) waits for a lock, it adds the angle by which that flux turns the observed EMF (R17).
void lode_drive_lessen_saturated(lode_drive_t *self, lode_ab_t i_A);
void lode_drive_adapt_saturated_lag(lode_drive_t *self);
#endif

// In drive_watch.c: rare cases. A sample failed the guard's fast checks; a trip switches off at once.
void lode_drive_diagnose(lode_drive_t *self, const lode_sense_t *sense, const lode_sample_t *sample,
                         lode_shorted_t *shorted);
// The guard's slow checks have found something to count.
void lode_drive_check_slow(lode_drive_t *self);
// Counts the rounds in which the readings of temperature and bus do not change.
void lode_drive_count_still(lode_drive_t *self, uint16_t count, float v_bus_V);
// A current of a set has kept its count, or their sum is too large.
void lode_drive_suspect(lode_drive_t *self, lode_plausibility_t *watch,
                        const int32_t i[LODE_PHASES], float checks);
// In START with three phases: checks that each phase carries both half-waves. False, as below where nothing else is said: the
// gates are off, in FAULT or for another attempt of the start.
bool lode_drive_note_waves(lode_drive_t *self, const int32_t i[LODE_PHASES]);
// The current vector has hardly moved since an earlier check. True: it is frozen.
bool lode_drive_doubt_frozen(lode_drive_t *self, lode_frozen_t *frozen);
// The current has jumped: `jump_V` would have had to act in addition to voltage and EMF. True: the sample is kept out of the
// EMF.
bool lode_drive_note_jump(lode_drive_t *self, lode_ab_t i_A, lode_ab_t jump_V);
// In each period after a jump, until it is decided.
bool lode_drive_wait_jump(lode_drive_t *self);
// In RUN: a load beyond all torque, an EMF that the magnets' flux does not explain, a phase without a half-wave.
bool lode_drive_watch_load(lode_drive_t *self);
bool lode_drive_judge_flux(lode_drive_t *self);
bool lode_drive_watch_half_waves(lode_drive_t *self);

// RUN, where the current is far off its reference or has been so. False: current control has lost it (K49), and the drive is in
// FAULT.
bool lode_drive_watch_control(lode_drive_t *self);

#endif
