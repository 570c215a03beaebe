#include "plant/flux.h"

#include <math.h>

static plant_harmonic_t harmonic_of(double size, double phase) {
    return (plant_harmonic_t){.re = size * cos(phase), .im = size * sin(phase)};
}

/// The sum of two neighbouring harmonics in dq: the lower one turns backwards, the upper one forwards.
static plant_ripple_t ripple_of(plant_harmonic_t lower, plant_harmonic_t upper) {
    return (plant_ripple_t){
        .d_sin = -(lower.re + upper.re),
        .d_cos = -(lower.im + upper.im),
        .q_sin = lower.im - upper.im,
        .q_cos = upper.re - lower.re,
    };
}

void plant_flux_init(plant_motor_t *self, const plant_config_t *config) {
    const double psi = config->psi_Wb;
    const bool has_low = config->emf5_ratio > 0.0 || config->emf7_ratio > 0.0;
    const bool has_high = config->emf11_ratio > 0.0 || config->emf13_ratio > 0.0;
    const bool dual = self->sets == PLANT_SETS;
    self->harmonic5 = harmonic_of(psi * config->emf5_ratio, config->emf5_phase_rad);
    self->harmonic7 = harmonic_of(psi * config->emf7_ratio, config->emf7_phase_rad);
    self->harmonic11 = harmonic_of(psi * config->emf11_ratio, config->emf11_phase_rad);
    self->harmonic13 = harmonic_of(psi * config->emf13_ratio, config->emf13_phase_rad);
    self->has_dq_harmonics = has_high || (has_low && !dual);
    self->has_xy_harmonics = has_low && dual;
    self->ripple12 = ripple_of(self->harmonic11, self->harmonic13);
    if (!dual) {
        self->ripple6 = ripple_of(self->harmonic5, self->harmonic7);
    }
}

void plant_flux_ripple(const plant_motor_t *self, double cos_theta, double sin_theta, double *h_d,
                       double *h_q) {
    const double c = cos_theta, s = sin_theta;
    const double c2 = c * c - s * s, s2 = 2.0 * c * s;
    const double c6 = c2 * (4.0 * c2 * c2 - 3.0), s6 = s2 * (3.0 - 4.0 * s2 * s2);
    const double c12 = c6 * c6 - s6 * s6, s12 = 2.0 * c6 * s6;
    const plant_ripple_t *low = &self->ripple6, *high = &self->ripple12;
    *h_d = low->d_sin * s6 + low->d_cos * c6 + high->d_sin * s12 + high->d_cos * c12;
    *h_q = low->q_sin * s6 + low->q_cos * c6 + high->q_sin * s12 + high->q_cos * c12;
}

plant_vector_t plant_flux_ripple_xy(const plant_motor_t *self, double cos_theta, double sin_theta) {
    const double c = cos_theta, s = sin_theta;
    const double c2 = c * c - s * s, s2 = 2.0 * c * s;
    const double c6 = c2 * (4.0 * c2 * c2 - 3.0), s6 = s2 * (3.0 - 4.0 * s2 * s2);
    const double c5 = c6 * c + s6 * s, s5 = s6 * c - c6 * s;
    const double c7 = c6 * c - s6 * s, s7 = s6 * c + c6 * s;
    const plant_harmonic_t *h5 = &self->harmonic5, *h7 = &self->harmonic7;
    return (plant_vector_t){
        -(h5->re * s5 + h5->im * c5) - (h7->re * s7 + h7->im * c7),
        h5->re * c5 - h5->im * s5 - (h7->re * c7 - h7->im * s7),
    };
}

/// One harmonic's share of the flux; `turn` is its sense of rotation in its plane.
static void add_flux(const plant_harmonic_t *harmonic, double order, double turn, double theta,
                     plant_vector_t *flux) {
    const double c = cos(order * theta), s = sin(order * theta);
    flux->alpha += (harmonic->re * c - harmonic->im * s) / order;
    flux->beta += turn * (harmonic->re * s + harmonic->im * c) / order;
}

plant_planes_t plant_flux_magnet(const plant_motor_t *self, const plant_motor_state_t *state) {
    const double theta = state->theta_e_rad;
    plant_planes_t flux = {{self->psi_Wb * state->cos_theta, self->psi_Wb * state->sin_theta},
                           {0.0, 0.0}};
    if (self->has_xy_harmonics) {
        add_flux(&self->harmonic5, 5.0, 1.0, theta, &flux.xy);
        add_flux(&self->harmonic7, 7.0, -1.0, theta, &flux.xy);
    }
    if (!self->has_dq_harmonics) {
        return flux;
    }
    if (self->sets == 1) {
        add_flux(&self->harmonic5, 5.0, -1.0, theta, &flux.ab);
        add_flux(&self->harmonic7, 7.0, 1.0, theta, &flux.ab);
    }
    add_flux(&self->harmonic11, 11.0, -1.0, theta, &flux.ab);
    add_flux(&self->harmonic13, 13.0, 1.0, theta, &flux.ab);
    return flux;
}

plant_planes_t plant_flux_open_emf(const plant_motor_t *self, const plant_motor_state_t *state) {
    const double w = self->np * state->omega_m_rad_s;
    double h_d = 0.0, h_q = 0.0;
    plant_vector_t h = {0.0, 0.0};
    if (self->has_dq_harmonics) {
        plant_flux_ripple(self, state->cos_theta, state->sin_theta, &h_d, &h_q);
    }
    if (self->has_xy_harmonics) {
        h = plant_flux_ripple_xy(self, state->cos_theta, state->sin_theta);
    }
    const double e_d = w * h_d, e_q = w * (self->psi_Wb + h_q);
    return (plant_planes_t){
        .ab = {e_d * state->cos_theta - e_q * state->sin_theta,
               e_d * state->sin_theta + e_q * state->cos_theta},
        .xy = {w * h.alpha, w * h.beta},
    };
}
