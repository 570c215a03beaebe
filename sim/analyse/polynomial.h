/// Quotients, eigenvalues, linear systems and polynomials, small and complex, in double.
#ifndef RIG_ANALYSE_POLYNOMIAL_H
#define RIG_ANALYSE_POLYNOMIAL_H

#include <complex.h>
#include <stdbool.h>

static inline double squared_magnitude(double complex x) {
    return creal(x) * creal(x) + cimag(x) * cimag(x);
}

/// a/b for 1e-150 < |b| < 1e150, where |b|^2 neither overflows nor vanishes. All numbers here are within that: points
/// on the unit circle, gains, poles in rad/s and what follows from them by a few products. C's own operator also
/// scales and looks for infinities, and takes about five times as long.
static inline double complex quotient(double complex a, double complex b) {
    return a * conj(b) / squared_magnitude(b);
}

enum { MATRIX_MAX = 20 };

typedef double complex matrix_t[MATRIX_MAX][MATRIX_MAX];

/// Eigenvalues of the first n rows and columns, in no order; destroys `a`. Balanced, reduced to
/// Hessenberg form, then QR steps with Wilkinson's shift. False if it does not converge.
bool matrix_eigenvalues(int n, matrix_t a, double complex *values);

/// Solves a x = b in place (x in b); destroys `a`. False for a singular matrix.
bool matrix_solve(int n, matrix_t a, double complex *b);

/// c[0] + c[1] x + ... + c[degree] x^degree.
typedef struct {
    int degree;
    double c[MATRIX_MAX];
} polynomial_t;

polynomial_t polynomial_product(const polynomial_t *a, const polynomial_t *b);
polynomial_t polynomial_sum(const polynomial_t *a, const polynomial_t *b);
double complex polynomial_at(const polynomial_t *a, double complex x);

/// Its `degree` roots: the eigenvalues of the companion matrix. The leading coefficient counts.
bool polynomial_roots(const polynomial_t *a, double complex *roots);

/// The condition of paper 2's Table I for s^2 + (a1 + j b1) s + (a2 + j b2): all roots to the left.
bool routh_complex_second_order(double a1, double b1, double a2, double b2);

#endif
