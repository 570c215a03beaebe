#include "analyse/polynomial.h"

#include <float.h>
#include <math.h>

enum { QR_STEPS_MAX = 60, QR_STEPS_ODD = 12 };

// ---- Eigenvalues --------------------------------------------------------------------------------

static double size_of(double complex x) {
    return fabs(creal(x)) + fabs(cimag(x));
}

/// Scales row and column k by powers of two until they are about equally large.
static bool balance_one(int n, matrix_t a, int k) {
    double row = 0.0;
    double column = 0.0;
    for (int i = 0; i < n; ++i) {
        row += i == k ? 0.0 : size_of(a[k][i]);
        column += i == k ? 0.0 : size_of(a[i][k]);
    }
    if (!(row > 0.0) || !(column > 0.0)) {
        return false;
    }
    int power = 0;
    (void)frexp(sqrt(row / column), &power);
    const double f = ldexp(1.0, power - 1);
    if (!(f * column + row / f < 0.9 * (row + column))) {
        return false;
    }
    for (int i = 0; i < n; ++i) {
        a[k][i] /= f;
        a[i][k] *= f;
    }
    return true;
}

static void balance(int n, matrix_t a) {
    for (int round = 0; round < 20; ++round) {
        bool changed = false;
        for (int k = 0; k < n; ++k) {
            changed = balance_one(n, a, k) || changed;
        }
        if (!changed) {
            return;
        }
    }
}

static void swap_rows_and_columns(int n, matrix_t a, int p, int q) {
    for (int i = 0; i < n; ++i) {
        const double complex kept = a[p][i];
        a[p][i] = a[q][i];
        a[q][i] = kept;
    }
    for (int i = 0; i < n; ++i) {
        const double complex kept = a[i][p];
        a[i][p] = a[i][q];
        a[i][q] = kept;
    }
}

/// Subtracts row m times a factor from row i, and adds column i times that factor to column m.
static void eliminate(int n, matrix_t a, int m, int i) {
    const double complex f = quotient(a[i][m - 1], a[m][m - 1]);
    for (int j = m; j < n; ++j) { // zeros before that
        a[i][j] -= f * a[m][j];
    }
    for (int j = 0; j < n; ++j) {
        a[j][m] += f * a[j][i];
    }
    a[i][m - 1] = 0.0;
}

/// Hessenberg form by elimination with pivots.
static void reduce(int n, matrix_t a) {
    for (int m = 1; m < n - 1; ++m) {
        int pivot = m;
        for (int i = m + 1; i < n; ++i) {
            pivot = size_of(a[i][m - 1]) > size_of(a[pivot][m - 1]) ? i : pivot;
        }
        if (!(size_of(a[pivot][m - 1]) > 0.0)) {
            continue;
        }
        if (pivot != m) {
            swap_rows_and_columns(n, a, m, pivot);
        }
        for (int i = m + 1; i < n; ++i) {
            eliminate(n, a, m, i);
        }
    }
}

/// The eigenvalue of the trailing 2 x 2 block that is nearer to its last element.
static double complex wilkinson(matrix_t a, int last) {
    const double complex p = a[last - 1][last - 1];
    const double complex q = a[last][last];
    const double complex half = 0.5 * (p - q);
    const double complex root = csqrt(half * half + a[last - 1][last] * a[last][last - 1]);
    const double complex sum = creal(half * conj(root)) < 0.0 ? half - root : half + root;
    return size_of(sum) > 0.0 ? q - quotient(a[last - 1][last] * a[last][last - 1], sum) : q;
}

/// One QR step on rows and columns first .. last: rotations from the left, then from the right.
static void qr_step(matrix_t a, int first, int last, double complex shift) {
    double cosine[MATRIX_MAX] = {0.0};
    double complex sine[MATRIX_MAX] = {0.0};
    for (int k = first; k <= last; ++k) {
        a[k][k] -= shift;
    }
    for (int k = first; k < last; ++k) {
        const double own = sqrt(squared_magnitude(a[k][k]));
        const double length = sqrt(own * own + squared_magnitude(a[k + 1][k]));
        const double complex turn = own > 0.0 ? a[k][k] / own : 1.0;
        cosine[k] = length > 0.0 ? own / length : 1.0;
        sine[k] = length > 0.0 ? turn * conj(a[k + 1][k]) / length : 0.0;
        for (int j = k; j <= last; ++j) {
            const double complex up = a[k][j];
            const double complex down = a[k + 1][j];
            a[k][j] = cosine[k] * up + sine[k] * down;
            a[k + 1][j] = cosine[k] * down - conj(sine[k]) * up;
        }
    }
    for (int k = first; k < last; ++k) {
        for (int i = first; i <= k + 1; ++i) {
            const double complex left = a[i][k];
            const double complex right = a[i][k + 1];
            a[i][k] = cosine[k] * left + conj(sine[k]) * right;
            a[i][k + 1] = cosine[k] * right - sine[k] * left;
        }
    }
    for (int k = first; k <= last; ++k) {
        a[k][k] += shift;
    }
}

/// First row of the last block that is not split by a zero below the diagonal.
static int block_start(matrix_t a, int last) {
    for (int k = last; k > 0; --k) {
        const double around = size_of(a[k - 1][k - 1]) + size_of(a[k][k]);
        if (size_of(a[k][k - 1]) <= DBL_EPSILON * around || !(size_of(a[k][k - 1]) > DBL_MIN)) {
            a[k][k - 1] = 0.0;
            return k;
        }
    }
    return 0;
}

bool matrix_eigenvalues(int n, matrix_t a, double complex *values) {
    balance(n, a);
    reduce(n, a);
    int steps = 0;
    int last = n - 1;
    while (last >= 0) {
        const int first = block_start(a, last);
        if (first == last) {
            values[last] = a[last][last];
            --last;
            steps = 0;
            continue;
        }
        if (++steps > QR_STEPS_MAX) {
            return false;
        }
        // Occasionally another shift, to avoid cycles.
        const double complex odd = a[last][last] + 0.75 * size_of(a[last][last - 1]);
        qr_step(a, first, last, steps % QR_STEPS_ODD == 0 ? odd : wilkinson(a, last));
    }
    return true;
}

// ---- Linear systems -----------------------------------------------------------------------------

/// Brings the largest of column k into row k. False if they are all zero.
static bool pivot_row(int n, matrix_t a, double complex *b, int k) {
    int pivot = k;
    for (int i = k + 1; i < n; ++i) {
        pivot = size_of(a[i][k]) > size_of(a[pivot][k]) ? i : pivot;
    }
    if (pivot != k) {
        for (int j = k; j < n; ++j) { // zeros before that
            const double complex kept = a[k][j];
            a[k][j] = a[pivot][j];
            a[pivot][j] = kept;
        }
        const double complex kept = b[k];
        b[k] = b[pivot];
        b[pivot] = kept;
    }
    return size_of(a[k][k]) > 0.0;
}

bool matrix_solve(int n, matrix_t a, double complex *b) {
    for (int k = 0; k < n; ++k) {
        if (!pivot_row(n, a, b, k)) {
            return false;
        }
        for (int i = k + 1; i < n; ++i) {
            const double complex f = quotient(a[i][k], a[k][k]);
            for (int j = k + 1; j < n; ++j) { // column k is not read again
                a[i][j] -= f * a[k][j];
            }
            b[i] -= f * b[k];
        }
    }
    for (int k = n - 1; k >= 0; --k) {
        for (int j = k + 1; j < n; ++j) {
            b[k] -= a[k][j] * b[j];
        }
        b[k] = quotient(b[k], a[k][k]);
    }
    return true;
}

// ---- Polynomials --------------------------------------------------------------------------------

polynomial_t polynomial_product(const polynomial_t *a, const polynomial_t *b) {
    polynomial_t product = {.degree = a->degree + b->degree};
    for (int i = 0; i <= a->degree; ++i) {
        for (int j = 0; j <= b->degree; ++j) {
            product.c[i + j] += a->c[i] * b->c[j];
        }
    }
    return product;
}

polynomial_t polynomial_sum(const polynomial_t *a, const polynomial_t *b) {
    polynomial_t sum = a->degree >= b->degree ? *a : *b;
    const polynomial_t *other = a->degree >= b->degree ? b : a;
    for (int i = 0; i <= other->degree; ++i) {
        sum.c[i] += other->c[i];
    }
    return sum;
}

double complex polynomial_at(const polynomial_t *a, double complex x) {
    double complex sum = 0.0;
    for (int i = a->degree; i >= 0; --i) {
        sum = sum * x + a->c[i];
    }
    return sum;
}

bool polynomial_roots(const polynomial_t *a, double complex *roots) {
    matrix_t companion = {{0.0}};
    const int n = a->degree;
    for (int i = 0; i < n; ++i) {
        companion[i][n - 1] = -a->c[i] / a->c[n];
        if (i > 0) {
            companion[i][i - 1] = 1.0;
        }
    }
    return matrix_eigenvalues(n, companion, roots);
}

bool routh_complex_second_order(double a1, double b1, double a2, double b2) {
    // a0 = 1: second row a1 b2, third row b1' = a1 b1 - a0 b2, a2' = a1 a2, last a1 a2' + b1' b2.
    return a1 > 0.0 && a1 * (a1 * a2) + (a1 * b1 - b2) * b2 > 0.0;
}
