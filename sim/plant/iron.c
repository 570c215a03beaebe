#include "plant/iron.h"

#include <math.h>
#include <stddef.h>

#define SQRT3 1.73205080756887729353

/// |dX/did diq| is largest at (3/8) sqrt(3) of cross_H, at iq = i_cross_A / sqrt(3) and id = 0.
#define CROSS_PER_LARGEST (8.0 / (3.0 * SQRT3))
/// Largest second derivatives of X by id and by iq, in cross_H: 48/25/sqrt(5) and 2.
#define CROSS_DD_MAX 0.85865
#define CROSS_QQ_MAX 2.0

/// A correction below this share of the current is rounding.
static const double step_enough = 1e-8;
/// Current below which `step_enough` is absolute, A.
static const double current_floor_A = 1e-6;

bool plant_iron_saturates(const plant_config_t *c) {
    return c->map != NULL || c->id_sat_A > 0.0 || c->i_sat_A > 0.0 || c->i_cross_A > 0.0;
}

void plant_iron_init(plant_iron_t *self, const plant_config_t *c) {
    const bool d = c->id_sat_A > 0.0, q = c->i_sat_A > 0.0, cross = c->i_cross_A > 0.0;
    *self = (plant_iron_t){
        .map = c->map,
        .Ld_H = c->Ld_H,
        .Lq_H = c->Lq_H,
        .Lq_sat_H = q ? c->Lq_sat_H : c->Lq_H,
        .Ld_fall = d ? 1.0 - c->Ld_sat_H / c->Ld_H : 0.0,
        .inv_id_sat = d ? 1.0 / c->id_sat_A : 0.0,
        .inv_i_sat = q ? 1.0 / c->i_sat_A : 0.0,
        .i_cross_A = cross ? SQRT3 * c->i_cross_A : 0.0,
        .cross_H = cross ? CROSS_PER_LARGEST * c->Ldq_H : 0.0,
    };
    // The least eigenvalue with each of the three terms at its worst, even if at different currents.
    const double d_H = c->Ld_H * (1.0 - self->Ld_fall) - CROSS_DD_MAX * fabs(self->cross_H);
    const double q_H = self->Lq_sat_H - CROSS_QQ_MAX * fabs(self->cross_H);
    const double half_H = hypot(0.5 * (d_H - q_H), self->cross_H / CROSS_PER_LARGEST);
    const double all_H = cross ? 0.5 * (d_H + q_H) - half_H : fmin(d_H, q_H);
    self->smallest_L_H = c->map != NULL ? c->map->smallest_L_H : all_H;
}

static bool within(double value, double low, double high) {
    return value >= low && value <= high;
}

const char *plant_iron_check(const plant_config_t *c) {
    if (!within(c->i_sat_A, 0.0, 1e6)) {
        return "i_sat_A must be 0 (linear) ..1e6";
    }
    if (c->i_sat_A > 0.0 && !within(c->Lq_sat_H, 1e-9, c->Lq_H)) {
        return "Lq_sat_H must be 1e-9..Lq_H";
    }
    if (!within(c->id_sat_A, 0.0, 1e6)) {
        return "id_sat_A must be 0 (linear) ..1e6";
    }
    if (c->id_sat_A > 0.0 && !within(c->Ld_sat_H, 1e-9, c->Ld_H)) {
        return "Ld_sat_H must be 1e-9..Ld_H";
    }
    if (!within(c->i_cross_A, 0.0, 1e6) || !within(c->Ldq_H, -1e3, 1e3)) {
        return "i_cross_A must be 0 (no cross-saturation) ..1e6, Ldq_H -1e3..1e3";
    }
    plant_iron_t iron;
    plant_iron_init(&iron, c);
    if (!(iron.smallest_L_H > 0.0)) {
        return "Ldq_H, too large: with the smallest differential Ld and Lq the currents would not "
               "follow from the fluxes";
    }
    return NULL;
}

plant_iron_point_t plant_iron_at(const plant_iron_t *self, double id_A, double iq_A) {
    if (self->map != NULL) {
        const plant_map_value_t of = plant_map_at(self->map, id_A, iq_A);
        return (plant_iron_point_t){of.d - self->map->psi_Wb, of.q - self->map->psi_q_Wb, of.dd,
                                    of.dq, of.qq};
    }
    // D: the inductance falls by Ld_fall x / sqrt(1 + x^2).
    const double x = id_A * self->inv_id_sat, r = sqrt(1.0 + x * x);
    // Q: Lq_sat iq + (Lq - Lq_sat) iq / (1 + |iq|/i_sat).
    const double fade = 1.0 / (1.0 + fabs(iq_A) * self->inv_i_sat);
    const double swing_H = self->Lq_H - self->Lq_sat_H;
    plant_iron_point_t at = {
        // r - 1 without cancellation
        .psi_d_Wb = self->Ld_H * id_A * (1.0 - self->Ld_fall * x / (1.0 + r)),
        .psi_q_Wb = iq_A * (self->Lq_sat_H + swing_H * fade),
        .Ldd_H = self->Ld_H * (1.0 - self->Ld_fall * x / r),
        .Lqq_H = self->Lq_sat_H + swing_H * fade * fade,
    };
    if (self->i_cross_A > 0.0) {
        // X = -cross_H i^2 g(id/i) h(iq/i) with g = u/sqrt(1 + u^2), h = v^2/(1 + v^2).
        const double u = id_A / self->i_cross_A, v = iq_A / self->i_cross_A;
        const double a = 1.0 / (1.0 + u * u), b = 1.0 / (1.0 + v * v), g1 = a * sqrt(a);
        const double h = v * v * b, h1 = 2.0 * v * b * b;
        const double g = u * sqrt(a), g2 = -3.0 * u * g1 * a;
        const double h2 = 2.0 * (1.0 - 3.0 * v * v) * b * b * b;
        const double size_Wb = -self->cross_H * self->i_cross_A;
        at.psi_d_Wb += size_Wb * g1 * h;
        at.psi_q_Wb += size_Wb * g * h1;
        at.Ldd_H -= self->cross_H * g2 * h;
        at.Ldq_H = -self->cross_H * g1 * h1;
        at.Lqq_H -= self->cross_H * g * h2;
    }
    return at;
}

plant_iron_answer_t plant_iron_answer(const plant_iron_point_t *at) {
    const double scale = 1.0 / (at->Ldd_H * at->Lqq_H - at->Ldq_H * at->Ldq_H);
    return (plant_iron_answer_t){scale * at->Lqq_H, -scale * at->Ldq_H, scale * at->Ldd_H};
}

void plant_iron_currents(const plant_iron_t *self, double psi_d_Wb, double psi_q_Wb, double *id_A,
                         double *iq_A) {
    enum { STEPS = 100 };
    plant_iron_point_t at = plant_iron_at(self, *id_A, *iq_A);
    double share = 1.0;
    // Newton's method; the step is halved if the residual does not fall.
    for (int n = 0; n < STEPS; n++) {
        const double d_Wb = psi_d_Wb - at.psi_d_Wb, q_Wb = psi_q_Wb - at.psi_q_Wb;
        const plant_iron_answer_t y = plant_iron_answer(&at);
        const double id = *id_A + share * (y.dd * d_Wb + y.dq * q_Wb);
        const double iq = *iq_A + share * (y.dq * d_Wb + y.qq * q_Wb);
        const double step_A = fabs(id - *id_A) + fabs(iq - *iq_A);
        if (step_A <= step_enough * (fabs(*id_A) + fabs(*iq_A) + current_floor_A)) {
            *id_A = id;
            *iq_A = iq;
            return;
        }
        const plant_iron_point_t next = plant_iron_at(self, id, iq);
        const double d = psi_d_Wb - next.psi_d_Wb, q = psi_q_Wb - next.psi_q_Wb;
        if (d * d + q * q < d_Wb * d_Wb + q_Wb * q_Wb) {
            *id_A = id;
            *iq_A = iq;
            at = next;
            share = 1.0;
        } else {
            share *= 0.5;
        }
    }
}

double plant_iron_energy(const plant_iron_t *self, double id_A, double iq_A) {
    if (self->map != NULL) {
        const plant_map_value_t of = plant_map_at(self->map, id_A, iq_A);
        return id_A * of.d + iq_A * of.q - (of.W - self->map->W_J);
    }
    const plant_iron_point_t at = plant_iron_at(self, id_A, iq_A);
    double W = 0.5 * self->Ld_H * id_A * id_A + 0.5 * self->Lq_sat_H * iq_A * iq_A;
    if (self->inv_id_sat > 0.0) {
        // integral of sqrt(1 + x^2) - 1
        const double x = id_A * self->inv_id_sat;
        W -= self->Ld_H * self->Ld_fall / (self->inv_id_sat * self->inv_id_sat) *
             (0.5 * (x * sqrt(1.0 + x * x) + asinh(x)) - x);
    }
    if (self->inv_i_sat > 0.0) {
        // integral of y / (1 + y)
        const double y = fabs(iq_A) * self->inv_i_sat;
        W += (self->Lq_H - self->Lq_sat_H) / (self->inv_i_sat * self->inv_i_sat) * (y - log1p(y));
    } else {
        W += 0.5 * (self->Lq_H - self->Lq_sat_H) * iq_A * iq_A;
    }
    if (self->i_cross_A > 0.0) {
        const double u = id_A / self->i_cross_A, v = iq_A / self->i_cross_A;
        W -= self->cross_H * self->i_cross_A * self->i_cross_A * u / sqrt(1.0 + u * u) * v * v /
             (1.0 + v * v);
    }
    return id_A * at.psi_d_Wb + iq_A * at.psi_q_Wb - W;
}
