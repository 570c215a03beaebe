#include "commission_parts.h"

#ifndef LODE_WITHOUT_COMMISSIONING

#define PHASES ((uint32_t)LODE_PHASES)

// Signals: pulses along each phase, first forward, then back, so that the rotor stays where it is; then rest.
#define PULSE_PERIODS 5u
#define REST_PERIODS 60u
#define PULSE_SHARE 0.15f // of i_max, by the smaller inductance
#define PULSE_SEEN 0.08f  // the same, by the larger one; with less the voltage is raised
#define PULSES_MOST 12u
// Least current of the driven phase over the largest: saliency turns the vector by up to 35 degrees.
#define DRIVEN_LEAST 0.7f
#define SUM_MOST 0.25f // of the same: largest sum of the currents
// Largest current of the xy plane over the vector. Both sets see the same but for dead time, which makes up to 0.3; sensors
// swapped between the sets make 0.6.
#define XY_MOST 0.45f
#define NOISE_MOST 0.02f // of full scale, peak to peak
#define OFFSET_SAMPLES 1024u

// --- Offsets ---

// Extremes and sum of the counts.
static void note_counts(lode_commission_t *self, const lode_counts_t *counts) {
    lode_commission_counts_t *k = &self->counts;
    for (uint32_t x = 0u; x < PHASES; x++) {
        const float count = (float)counts->i[x];
        const bool first = self->since == 0u;
        k->least[x] = first ? count : lode_min(k->least[x], count);
        k->most[x] = first ? count : lode_max(k->most[x], count);
        k->sum[x] = (first ? 0.0f : k->sum[x]) + count;
    }
}

// False: refused.
static bool judge_offsets(lode_commission_t *self) {
    const lode_sense_config_t *sense = &self->designed.sense;
    const lode_commission_counts_t *k = &self->counts;
    for (uint32_t x = 0u; x < PHASES; x++) {
        const bool there = x < 2u || sense->shunts == LODE_SHUNTS_THREE;
        const float span = there ? k->most[x] - k->least[x] : 0.0f;
        if (!lode_commission_keep(self, lode_commission_offset_of(PHASES * self->level + x),
                                  k->sum[x] / lode_commission_float(OFFSET_SAMPLES), span,
                                  NOISE_MOST * sense->count_max)) {
            return false;
        }
    }
    return true;
}

// Measures one set after the other, then starts the drive's own calibration.
void lode_commission_calibrate(lode_commission_t *self, const lode_commission_period_t *period) {
    if (self->since < OFFSET_SAMPLES) {
        note_counts(self, period->set[self->level]);
    } else if (self->since == OFFSET_SAMPLES) {
        if (!judge_offsets(self)) {
            return;
        }
        if (self->level + 1u < self->sets) {
            self->level++;
            lode_commission_restart(self);
        } else {
            lode_commission_post(self, (lode_command_t){.mode = LODE_MODE_CALIBRATE});
        }
    } else if (lode_drive_knows(self->drive, LODE_KNOWN_OFFSETS)) {
        self->quantity = LODE_COMMISSION_SIGNALS;
        self->level = 0u;
        lode_commission_enter(self, STAGE_PULSES);
    } else {
        // the drive calibrates, or trips
    }
}

// --- Signals ---

// Stores phase currents and the current of the xy plane at the largest length of the vector.
static void note_peak(lode_commission_t *self, const lode_commission_period_t *period,
                      lode_dq_t i_A) {
    const lode_counts_t *counts = period->set[self->level / PHASES];
    const lode_sense_config_t *sense = &self->designed.sense;
    lode_commission_peak_t *peak = &self->peak;
    const float length_A = lode_commission_length(i_A);
    if (length_A <= peak->length_A) {
        return;
    }
    peak->xy_A = lode_ab_length(period->i_xy_A);
    peak->length_A = length_A;
    for (uint32_t x = 0u; x < PHASES; x++) {
        const float offset = lode_commission_found(
            self, lode_commission_offset_of(PHASES * (self->level / PHASES) + x));
        peak->phase_A[x] = sense->i_gain_A_count * ((float)counts->i[x] - offset);
    }
    if (sense->shunts == LODE_SHUNTS_TWO) {
        peak->phase_A[2] = -(peak->phase_A[0] + peak->phase_A[1]);
    }
}

// A wrong sign or place makes the current of the driven phase small or negative, a dead sensor leaves a sum, and a sensor in
// the wrong set makes current of the xy plane.
static bool judge_phase(lode_commission_t *self, uint32_t driven) {
    const lode_commission_peak_t *peak = &self->peak;
    const float *i = peak->phase_A;
    const float largest = lode_max(lode_max(lode_abs(i[0]), lode_abs(i[1])), lode_abs(i[2]));
    const float inv = 1.0f / lode_max(largest, FLT_MIN);
    const float off = 1.0f - i[driven % PHASES] * inv;
    const float sum = lode_abs(i[0] + i[1] + i[2]) * inv;
    const float xy = peak->xy_A / lode_max(peak->length_A, FLT_MIN);
    const float worst =
        lode_max(lode_max(off / (1.0f - DRIVEN_LEAST), sum / SUM_MOST), xy / XY_MOST);
    const float least_A = NOISE_MOST * self->designed.inverter.i_max_A;
    return lode_commission_keep(self, LODE_COMMISSION_SIGNALS, lode_commission_float(driven + 1u),
                                peak->length_A > least_A ? worst : 2.0f, 1.0f);
}

// Voltage along the driven phase: by the known values at first, then more, as the dead time may take more.
static float pulse_V(const lode_commission_t *self) {
    const lode_motor_t *motor = &self->designed.motor;
    const float step_A = PULSE_SHARE * self->designed.inverter.i_max_A;
    const float rise_s = lode_commission_float(PULSE_PERIODS) / self->config.f_pwm_Hz;
    const float rise_V = lode_min(motor->Ld_H, motor->Lq_H) * step_A / rise_s;
    return lode_commission_dead_along(self) * lode_commission_dead_known_V(&self->designed) +
           rise_V * (1.0f + 0.5f * lode_commission_float(self->tries));
}

// Repeats the pulse with more voltage, or goes on to the next phase.
static void end_pulse(lode_commission_t *self) {
    const float seen_A = PULSE_SEEN * self->designed.inverter.i_max_A;
    if (self->peak.length_A < seen_A && self->tries < PULSES_MOST) {
        self->tries++;
        lode_commission_restart(self);
    } else if (judge_phase(self, self->level)) {
        self->peak.length_A = 0.0f;
        self->tries = 0u;
        self->level++;
        lode_commission_enter(self,
                              self->level < PHASES * self->sets ? STAGE_PULSES : STAGE_ACROSS);
    } else {
        // refused
    }
}

// Axis of a phase; set 2 is 30 degrees ahead of set 1.
static float phase_rad(uint32_t phase) {
    const float set_2_rad = phase < PHASES ? 0.0f : LODE_PI / 6.0f;
    return set_2_rad + LODE_TWO_PI / 3.0f * lode_commission_float(phase % PHASES);
}

void lode_commission_pulse(lode_commission_t *self, const lode_commission_period_t *period,
                           lode_dq_t i_A) {
    const lode_sincos_t axis = lode_sincos(phase_rad(self->level) - self->axis_rad);
    const float pulse_u_V = pulse_V(self);
    float u_V = 0.0f;
    if (self->since < PULSE_PERIODS) {
        u_V = pulse_u_V;
    } else if (self->since < 2u * PULSE_PERIODS) {
        u_V = -pulse_u_V;
    } else {
        // rest
    }
    lode_commission_post_vector(self, LODE_MODE_VOLTAGE, u_V * axis.cos, u_V * axis.sin);
    if (self->since < PULSE_PERIODS + SEEN_PERIODS) {
        note_peak(self, period, i_A);
    } else if (self->since >= REST_PERIODS) {
        end_pulse(self);
    } else {
        // the current decays
    }
}

#endif
