#include "plant/sets.h"

const double plant_axis_cos[PLANT_LEGS] = {1.0, -0.5, -0.5, PLANT_SQRT3_2, -PLANT_SQRT3_2, 0.0};
const double plant_axis_sin[PLANT_LEGS] = {0.0, PLANT_SQRT3_2, -PLANT_SQRT3_2, 0.5, 0.5, -1.0};

enum { ROWS = 2 * PLANT_SETS };

/// One current that is held constant: the component of a set's vector along a direction.
typedef struct {
    int set;
    double c, s;
} row_t;

static int rows_of(const int floating[PLANT_SETS], row_t row[ROWS]) {
    int rows = 0;
    for (int set = 0; set < PLANT_SETS; set++) {
        const int n = floating[set];
        if (n == PLANT_ALL_FLOAT) {
            row[rows++] = (row_t){set, 1.0, 0.0};
            row[rows++] = (row_t){set, 0.0, 1.0};
        } else if (n != PLANT_NONE_FLOATS) {
            row[rows++] = (row_t){set, plant_axis_cos[n], plant_axis_sin[n]};
        }
    }
    return rows;
}

/// Slope of the current of row p for 1 V along row q.
static double answer(const plant_compliance_t *m, const row_t *p, const row_t *q) {
    const double alpha = m->alpha_alpha * q->c + m->alpha_beta * q->s;
    const double beta = m->alpha_beta * q->c + m->beta_beta * q->s;
    const double xy = m->xy * (p->c * q->c + p->s * q->s);
    return 0.5 * (p->c * alpha + p->s * beta + (p->set == q->set ? xy : -xy));
}

/// Gauss without pivoting: the matrix is symmetric and positive definite.
static void solve(double a[ROWS][ROWS], double x[ROWS], int n) {
    for (int k = 0; k < n; k++) {
        for (int r = k + 1; r < n; r++) {
            const double factor = a[r][k] / a[k][k];
            for (int c = k; c < n; c++) {
                a[r][c] -= factor * a[k][c];
            }
            x[r] -= factor * x[k];
        }
    }
    for (int k = n - 1; k >= 0; k--) {
        for (int c = k + 1; c < n; c++) {
            x[k] -= a[k][c] * x[c];
        }
        x[k] /= a[k][k];
    }
}

void plant_sets_hold(const plant_compliance_t *compliance, const int floating[PLANT_SETS],
                     const plant_vector_t rate[PLANT_SETS], plant_vector_t push_V[PLANT_SETS]) {
    row_t row[ROWS];
    double a[ROWS][ROWS], x[ROWS];
    const int rows = rows_of(floating, row);
    for (int p = 0; p < rows; p++) {
        const plant_vector_t *slope = &rate[row[p].set];
        x[p] = -(row[p].c * slope->alpha + row[p].s * slope->beta);
        for (int q = 0; q < rows; q++) {
            a[p][q] = answer(compliance, &row[p], &row[q]);
        }
    }
    solve(a, x, rows);
    for (int set = 0; set < PLANT_SETS; set++) {
        push_V[set] = (plant_vector_t){0.0, 0.0};
    }
    for (int p = 0; p < rows; p++) {
        push_V[row[p].set].alpha += row[p].c * x[p];
        push_V[row[p].set].beta += row[p].s * x[p];
    }
}
