#include "plant/map.h"

#include <math.h>
#include <stddef.h>

/// Reciprocity: largest difference of dpsi_d/diq and dpsi_q/did of a cell, as a share of the geometric mean of
/// the inductances. The torques from fluxes and from energy then differ by a few per cent.
static const double asymmetry_max = 0.1;
/// Points per cell and axis at which the inductances must be positive, both edges included.
enum { LOOKS = 5 };

/// The value and first two slopes along one axis of the four Hermite polynomials of a cell: value at its
/// start and end, slope at its start and end.
typedef struct {
    double of[3][4];
} hermite_t;

static hermite_t hermite(double x, double h) {
    const double a = 1.0 / h, b = a * a;
    return (hermite_t){{
        {1.0 + x * x * (2.0 * x - 3.0), x * x * (3.0 - 2.0 * x), h * x * (1.0 + x * (x - 2.0)),
         h * x * x * (x - 1.0)},
        {a * 6.0 * x * (x - 1.0), a * 6.0 * x * (1.0 - x), 1.0 + x * (3.0 * x - 4.0),
         x * (3.0 * x - 2.0)},
        {b * (12.0 * x - 6.0), b * (6.0 - 12.0 * x), a * (6.0 * x - 4.0), a * (6.0 * x - 2.0)},
    }};
}

static const plant_map_node_t *node_at(const plant_map_t *self, int row, int column) {
    return &self->node[row * self->columns + column];
}

/// The cell of an axis that holds a current.
static int cell_of(const double *at_A, int nodes, double i_A) {
    int low = 0, high = nodes - 1;
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        if (i_A < at_A[middle]) {
            high = middle;
        } else {
            low = middle;
        }
    }
    return low;
}

/// Slope number `d` along d and `q` along q.
static double sum(const plant_map_t *self, int row, int column, const double *d, const double *q) {
    double total = 0.0;
    for (int a = 0; a < 2; a++) {
        for (int b = 0; b < 2; b++) {
            const plant_map_node_t *n = node_at(self, row + a, column + b);
            total += d[a] * (q[b] * n->W + q[2 + b] * n->q) +
                     d[2 + a] * (q[b] * n->d + q[2 + b] * n->dq);
        }
    }
    return total;
}

static plant_map_value_t in_cell(const plant_map_t *self, int row, int column, double x, double y) {
    const hermite_t d = hermite(x, self->id_A[row + 1] - self->id_A[row]);
    const hermite_t q = hermite(y, self->iq_A[column + 1] - self->iq_A[column]);
    return (plant_map_value_t){
        .W = sum(self, row, column, d.of[0], q.of[0]),
        .d = sum(self, row, column, d.of[1], q.of[0]),
        .q = sum(self, row, column, d.of[0], q.of[1]),
        .dd = sum(self, row, column, d.of[2], q.of[0]),
        .dq = sum(self, row, column, d.of[1], q.of[1]),
        .qq = sum(self, row, column, d.of[0], q.of[2]),
    };
}

static double held(double value, double low, double high) {
    return fmin(fmax(value, low), high);
}

bool plant_map_holds(const plant_map_t *self, double id_A, double iq_A) {
    return id_A >= self->id_A[0] && id_A <= self->id_A[self->rows - 1] && iq_A >= self->iq_A[0] &&
           iq_A <= self->iq_A[self->columns - 1];
}

plant_map_value_t plant_map_at(const plant_map_t *self, double id_A, double iq_A) {
    const double id = held(id_A, self->id_A[0], self->id_A[self->rows - 1]);
    const double iq = held(iq_A, self->iq_A[0], self->iq_A[self->columns - 1]);
    const int row = cell_of(self->id_A, self->rows, id);
    const int column = cell_of(self->iq_A, self->columns, iq);
    const double x = (id - self->id_A[row]) / (self->id_A[row + 1] - self->id_A[row]);
    const double y = (iq - self->iq_A[column]) / (self->iq_A[column + 1] - self->iq_A[column]);
    plant_map_value_t at = in_cell(self, row, column, x, y);
    const double d = id_A - id, q = iq_A - iq;
    at.W += d * (at.d + 0.5 * d * at.dd) + q * (at.q + 0.5 * q * at.qq) + d * q * at.dq;
    at.d += at.dd * d + at.dq * q;
    at.q += at.dq * d + at.qq * q;
    return at;
}

/// Slope at node k of values `stride` apart: that of the parabola through the node and its neighbours.
static double slope_of(const double *value, int stride, const double *at, int nodes, int k) {
    const int m = k == 0 ? 1 : (k == nodes - 1 ? nodes - 2 : k);
    const double h0 = at[m] - at[m - 1], h1 = at[m + 1] - at[m];
    const double s0 = (value[m * stride] - value[(m - 1) * stride]) / h0;
    const double s1 = (value[(m + 1) * stride] - value[m * stride]) / h1;
    const double bend = (s1 - s0) / (h0 + h1);
    return s0 + bend * (2.0 * at[k] - at[m - 1] - at[m]);
}

/// Gain of the co-energy from node k to the next: trapezoidal rule with end correction.
static double gain_of(const double *flux, int stride, const double *at, int nodes, int k) {
    const double h = at[k + 1] - at[k];
    return 0.5 * h * (flux[k * stride] + flux[(k + 1) * stride]) -
           h * h / 12.0 *
               (slope_of(flux, stride, at, nodes, k + 1) - slope_of(flux, stride, at, nodes, k));
}

/// The co-energy of every node, as the mean over two paths: first along d, then q, and the reverse.
static void find_energy(plant_map_t *self, const double *psi_d, const double *psi_q) {
    const int rows = self->rows, columns = self->columns;
    double along_d[PLANT_MAP_MOST] = {0.0}, along_q[PLANT_MAP_MOST] = {0.0};
    for (int r = 0; r < rows; r++) {
        if (r > 0) {
            along_d[0] += gain_of(psi_d, columns, self->id_A, rows, r - 1);
        }
        double by_q = along_d[0];
        for (int c = 0; c < columns; c++) {
            if (c > 0) {
                by_q += gain_of(&psi_q[r * columns], 1, self->iq_A, columns, c - 1);
            }
            if (r == 0) {
                along_q[c] = by_q;
            } else {
                along_q[c] += gain_of(&psi_d[c], columns, self->id_A, rows, r - 1);
            }
            self->node[r * columns + c] = (plant_map_node_t){
                .W = 0.5 * (by_q + along_q[c]),
                .d = psi_d[r * columns + c],
                .q = psi_q[r * columns + c],
                .dq = 0.5 * (slope_of(&psi_d[r * columns], 1, self->iq_A, columns, c) +
                             slope_of(&psi_q[c], columns, self->id_A, rows, r)),
            };
        }
    }
}

/// (dpsi_q/did - dpsi_d/diq) of a cell: the circulation around it over its area.
static double asymmetry_of(const plant_map_t *self, int r, int c) {
    const plant_map_node_t *n00 = node_at(self, r, c), *n01 = node_at(self, r, c + 1);
    const plant_map_node_t *n10 = node_at(self, r + 1, c), *n11 = node_at(self, r + 1, c + 1);
    return 0.5 * (n10->q + n11->q - n00->q - n01->q) / (self->id_A[r + 1] - self->id_A[r]) -
           0.5 * (n01->d + n11->d - n00->d - n10->d) / (self->iq_A[c + 1] - self->iq_A[c]);
}

/// The least differential inductance in any direction; comparisons with NaN are false.
static double least_of(const plant_map_value_t *at) {
    return 0.5 * (at->dd + at->qq) - hypot(0.5 * (at->dd - at->qq), at->dq);
}

static plant_map_fault_t check_cell(plant_map_t *self, int r, int c) {
    double least_H = HUGE_VAL;
    for (int k = 0; k < LOOKS * LOOKS; k++) {
        const plant_map_value_t at = in_cell(self, r, c, (double)(k / LOOKS) / (LOOKS - 1),
                                             (double)(k % LOOKS) / (LOOKS - 1));
        least_H = fmin(least_H, least_of(&at));
    }
    const plant_map_value_t middle = in_cell(self, r, c, 0.5, 0.5);
    const double asymmetry_H = asymmetry_of(self, r, c);
    self->smallest_L_H = fmin(self->smallest_L_H, least_H);
    if (!(least_H > 0.0)) {
        return (plant_map_fault_t){"fluxes that rise with their currents", r, c, least_H};
    }
    if (!(fabs(asymmetry_H) <= asymmetry_max * sqrt(middle.dd * middle.qq))) {
        return (plant_map_fault_t){"dpsi_q/di_d equal to dpsi_d/di_q", r, c, asymmetry_H};
    }
    return (plant_map_fault_t){NULL, r, c, 0.0};
}

plant_map_fault_t plant_map_init(plant_map_t *self, const double *psi_d_Wb,
                                 const double *psi_q_Wb) {
    self->psi_Wb = 0.0;
    self->smallest_L_H = HUGE_VAL;
    find_energy(self, psi_d_Wb, psi_q_Wb);
    for (int r = 0; r < self->rows - 1; r++) {
        for (int c = 0; c < self->columns - 1; c++) {
            const plant_map_fault_t fault = check_cell(self, r, c);
            if (fault.why != NULL) {
                return fault;
            }
        }
    }
    const plant_map_value_t none = plant_map_at(self, 0.0, 0.0);
    self->psi_Wb = none.d;
    self->psi_q_Wb = none.q;
    self->W_J = none.W;
    self->Ld_H = none.dd;
    self->Lq_H = none.qq;
    return (plant_map_fault_t){NULL, 0, 0, 0.0};
}
