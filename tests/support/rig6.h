/// A six-phase drive on a dual three-phase machine in double with an ideal inverter and 12-bit
/// ADCs. The machine is Eldeeb's (IEEE PEDS 2017); inertia and bus voltage are assumed.
#ifndef SUPPORT_RIG6_H
#define SUPPORT_RIG6_H

#include "support/check.h"

#include "lodestar/drive6.h"

#include <complex.h>

#define RIG6_R 0.8
#define RIG6_LD 6.4e-3
#define RIG6_LQ 17.4e-3
#define RIG6_LXY 0.9e-3
#define RIG6_PSI 0.1746
#define RIG6_NP 5.0
#define RIG6_J 0.01
#define RIG6_B 1.0e-3
#ifndef RIG6_V_BUS
#define RIG6_V_BUS 300.0
#endif
#define RIG6_TS_s 1.0e-4
#define RIG6_GAIN_A 0.0125
#ifndef RIG6_GAIN_V
#define RIG6_GAIN_V 0.1
#endif
#ifndef RIG6_PARTS
#define RIG6_PARTS 16
#endif

typedef double _Complex cplx_t;

static inline lode_drive6_config_t rig6_config(void) {
    return (lode_drive6_config_t){
        .drive =
            {.f_pwm_Hz = 10000.0f,
             .motor = {.pole_pairs = (float)RIG6_NP,
                       .Rs_Ohm = (float)RIG6_R,
                       .Ld_H = (float)RIG6_LD,
                       .Lq_H = (float)RIG6_LQ,
                       .psi_Wb = (float)RIG6_PSI,
                       .J_kgm2 = (float)RIG6_J,
                       .B_Nms = (float)RIG6_B},
             .inverter = {.v_bus_V = (float)RIG6_V_BUS, .i_max_A = 15.0f},
             .sense = {.i_gain_A_count = (float)RIG6_GAIN_A,
                       .i_offset_count = 2048.0f,
                       .v_bus_gain_V_count = (float)RIG6_GAIN_V},
             // Its rotor is light: the default's least speed is above the 300 rpm of many tests.
             .start = {.omega_handover_rad_s = 67.0f}},
        .Lxy_H = (float)RIG6_LXY};
}

typedef struct {
    lode_drive6_t drive;
    lode_drive6_out_t out;
    lode_drive6_out_t applied;
    cplx_t i_dq;
    cplx_t i_xy;  ///< stator axes
    double low_s; ///< for which the low sides have been on
    /// What the 5th harmonic of the EMF drives in pulses of the low sides, over the current of both sets.
    double pulse_xy;
    double theta;
    double omega; ///< electrical
    double load_Nm;
    double fifth; ///< of the EMF, share of the fundamental
    double seventh;
    int open;    ///< phase without connection, 1 .. 6; 0: none
    int carries; ///< it still carries currents of this sign, having one dead switch; 0: none
    double offset[6];
    bool trip[2];
    uint32_t stamp;
    double angle_error;
} rig6_t;

static inline void rig6_init(rig6_t *self, lode_drive6_tuning_t *tuning,
                             const lode_drive6_config_t *config) {
    const lode_drive_out_t idle = {{0.5f, 0.5f, 0.5f}, false};
    *self = (rig6_t){.applied = {{idle, idle}}};
    TEST_ASSERT_EQUAL_STRING("LODE_OK",
                             lode_status_name(lode_drive6_init(&self->drive, tuning, config)));
}

static inline double rig6_axis(int phase) {
    static const double degrees[6] = {0.0, 120.0, 240.0, 30.0, 150.0, 270.0};
    return degrees[phase] * CHECK_PI / 180.0;
}

static inline double rig6_current(const rig6_t *self, int phase) {
    const double at = rig6_axis(phase);
    return creal(self->i_dq * cexp(I * (self->theta - at)) + self->i_xy * cexp(-5.0 * I * at));
}

static inline double rig6_torque(const rig6_t *self) {
    const double flux = RIG6_PSI + (RIG6_LD - RIG6_LQ) * creal(self->i_dq);
    return 3.0 * RIG6_NP * flux * cimag(self->i_dq);
}

static inline uint16_t rig6_count(double x) {
    return (uint16_t)fmax(0.0, fmin(4095.0, floor(x + 0.5)));
}

static inline lode_counts6_t rig6_counts(const rig6_t *self) {
    lode_counts6_t counts;
    for (int set = 0; set < 2; set++) {
        counts.set[set] = (lode_counts_t){.v_bus = rig6_count(RIG6_V_BUS / RIG6_GAIN_V),
                                          .trip = self->trip[set],
                                          .stamp = self->stamp};
        for (int k = 0; k < 3; k++) {
            const int n = 3 * set + k;
            counts.set[set].i[k] =
                rig6_count(2048.0 + self->offset[n] + rig6_current(self, n) / RIG6_GAIN_A);
        }
    }
    return counts;
}

// Voltage vector of a set, stator axes, from its duties.
static inline cplx_t rig6_vector(lode_abc_t duty, int set) {
    cplx_t sum = 0.0;
    const double legs[3] = {(double)duty.a, (double)duty.b, (double)duty.c};
    for (int k = 0; k < 3; k++) {
        sum += 2.0 / 3.0 * RIG6_V_BUS * legs[k] * cexp(I * rig6_axis(3 * set + k));
    }
    return sum;
}

/// Both planes over `h`, with the voltages of both sets. An open phase's leg floats to where its current
/// stays zero.
static inline void rig6_carry(rig6_t *self, cplx_t v1, cplx_t v2, double h) {
    const double w = self->omega;
    const double theta = self->theta + 0.5 * h * w;
    const cplx_t turn = cexp(I * theta);
    const cplx_t u = 0.5 * (v1 + v2) * conj(turn);
    const double ed = -w * RIG6_LQ * cimag(self->i_dq);
    const double eq = w * (RIG6_LD * creal(self->i_dq) + RIG6_PSI);
    const cplx_t harmonic =
        I * w * RIG6_PSI *
        (self->fifth * cexp(5.0 * I * theta) - self->seventh * cexp(-7.0 * I * theta));
    double rise_d = (creal(u) - RIG6_R * creal(self->i_dq) - ed) / RIG6_LD;
    double rise_q = (cimag(u) - RIG6_R * cimag(self->i_dq) - eq) / RIG6_LQ;
    cplx_t rise_xy = (0.5 * conj(v1 - v2) - RIG6_R * self->i_xy - harmonic) / RIG6_LXY;
    if (self->open > 0) {
        const double at = rig6_axis(self->open - 1);
        const cplx_t axis = cexp(I * at) * conj(turn);
        const cplx_t axis5 = cexp(5.0 * I * at);
        const double now = rig6_current(self, self->open - 1) / h;
        const cplx_t along = (rise_d + I * rise_q + I * w * self->i_dq) * conj(axis);
        const double rise = creal(along) + creal(rise_xy * conj(axis5)) + 0.5 * now;
        const double per_V = (creal(axis) * creal(axis) / RIG6_LD +
                              cimag(axis) * cimag(axis) / RIG6_LQ + 1.0 / RIG6_LXY) /
                             3.0;
        const bool carries = self->carries * (0.5 * now + rise) > 0.0;
        const double floats = carries ? 0.0 : -rise / per_V;
        rise_d += floats * creal(axis) / (3.0 * RIG6_LD);
        rise_q += floats * cimag(axis) / (3.0 * RIG6_LQ);
        rise_xy += floats * axis5 / (3.0 * RIG6_LXY);
    }
    self->i_dq += h * (rise_d + I * rise_q);
    self->i_xy += h * rise_xy;
}

/// The set that is driven alone sees one machine; the other carries nothing.
static inline void rig6_carry_alone(rig6_t *self, cplx_t v, int set, double h) {
    const double w = self->omega;
    const double Ld = 0.5 * (RIG6_LD + RIG6_LXY);
    const double Lq = 0.5 * (RIG6_LQ + RIG6_LXY);
    const cplx_t turn = cexp(I * (self->theta + 0.5 * h * w));
    const cplx_t u = v * conj(turn);
    cplx_t i = 2.0 * self->i_dq;
    const double rise_d = (creal(u) - RIG6_R * creal(i) + w * Lq * cimag(i)) / Ld;
    const double rise_q = (cimag(u) - RIG6_R * cimag(i) - w * (Ld * creal(i) + RIG6_PSI)) / Lq;
    i += h * (rise_d + I * rise_q);
    self->i_dq = 0.5 * i;
    const cplx_t xy = 0.5 * conj(i * cexp(I * (self->theta + h * w)));
    self->i_xy = set == 0 ? xy : -xy;
}

/// Short-circuited by the low sides since half of their share ago; the diodes let the current die before the next.
static inline cplx_t rig6_pulse(rig6_t *self) {
    const double share = 1.0 - (double)self->applied.set[0].duty.a;
    self->low_s = share < 1.0 ? 0.5 * share * RIG6_TS_s : self->low_s + RIG6_TS_s;
    const double turned = self->low_s * self->omega;
    return RIG6_PSI * ((cos(turned) - 1.0) / RIG6_LD - I * sin(turned) / RIG6_LQ);
}

static inline void rig6_move(rig6_t *self) {
    const double h = RIG6_TS_s / RIG6_PARTS;
    const cplx_t v1 = rig6_vector(self->applied.set[0].duty, 0);
    const cplx_t v2 = rig6_vector(self->applied.set[1].duty, 1);
    for (int part = 0; part < RIG6_PARTS; part++) {
        const bool on_1 = self->out.set[0].gates == LODE_GATES_ON;
        const bool on_2 = self->out.set[1].gates == LODE_GATES_ON;
        if (on_1 && on_2) {
            rig6_carry(self, v1, v2, h);
        } else if (on_1 || on_2) {
            rig6_carry_alone(self, on_1 ? v1 : v2, on_1 ? 0 : 1, h);
        } else {
            self->i_dq = self->i_xy = 0.0;
        }
        const double drag =
            self->load_Nm * tanh(self->omega / 3.0) + RIG6_B * self->omega / RIG6_NP;
        self->theta = remainder(self->theta + h * self->omega, 2.0 * CHECK_PI);
        self->omega += h * RIG6_NP / RIG6_J * (rig6_torque(self) - drag);
    }
    if (self->out.set[0].gates == LODE_GATES_LOW && self->out.set[1].gates == LODE_GATES_LOW) {
        self->i_dq = rig6_pulse(self);
        self->i_xy = self->pulse_xy * cabs(self->i_dq) * cexp(-5.0 * I * self->theta);
    }
    self->applied = self->out;
}

static inline lode_telemetry6_t rig6_telemetry(const rig6_t *self) {
    lode_telemetry6_t telemetry;
    TEST_ASSERT_TRUE(lode_drive6_telemetry(&self->drive, &telemetry));
    return telemetry;
}

static inline void rig6_step(rig6_t *self) {
    self->stamp += 1000u;
    const lode_counts6_t counts = rig6_counts(self);
    const double theta = self->theta;
    self->out = lode_drive6_step(&self->drive, &counts);
    self->angle_error =
        remainder((double)rig6_telemetry(self).drive.theta_rad - theta, 2.0 * CHECK_PI);
    rig6_move(self);
}

static inline void rig6_run(rig6_t *self, double seconds) {
    for (int n = 0; n < (int)(seconds / RIG6_TS_s + 0.5); n++) {
        rig6_step(self);
    }
}

static inline void rig6_command(rig6_t *self, lode_command_t command) {
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_command(&self->drive.drive, &command));
}

#endif
