#include "analyse/paper1.h"

#include <math.h>
#include <stdio.h>

#include "analyse/loop.h"
#include "support/units.h"

// Paper 1's settings and printed figures: Jiang et al., Energies 2022, 15, 1943.
#define FIG4_SIGMA 200.0
#define FIG5_CENTRE 600.0
#define FIG8_SIGMA 100.0
#define NOTCH_K 0.1
#define FIG9_CENTRE 600.0
#define FROM_rad_s 10.0
#define TO_rad_s 1.0e4
#define FIG9_SIGMA_STEP 5.0

static const double fig8_centre[] = {500.0, 600.0, 700.0};

typedef struct {
    double sigma, crossover, phase, re, im;
} table2_t;

static const table2_t table2[] = {
    {80.0, 244.0, 68.0, -26.8, 587.7},
    {120.0, 365.0, 66.0, -22.9, 583.2},
    {160.0, 478.0, 58.0, -18.3, 580.1},
};

static double in_dB(double complex x) {
    return 20.0 * log10(cabs(x));
}

/// The curve below the frequency limit of a sampled system.
static double top_of(const analyse_t *self, analyse_form_t form) {
    return form == ANALYSE_SAMPLED ? fmin(TO_rad_s, 0.999 * RIG_PI / self->ts_s) : TO_rad_s;
}

// ---- Table 1 and Figure 4 -------------------------------------------------------------------------

static double ts_of(const analyse_t *self, analyse_form_t form) {
    return form == ANALYSE_SAMPLED ? self->ts_s : 0.0;
}

static loop_ratio_t pll(const analyse_t *self, analyse_form_t form, double sigma, bool third) {
    if (form == ANALYSE_AS_PRINTED) {
        return loop_pll_misprint(sigma);
    }
    return form == ANALYSE_SAMPLED ? loop_pll_sampled(sigma, third, self->ts_s)
                                   : loop_pll(sigma, third);
}

/// Share of a predicted error that remains after the correction.
static double left_over(const analyse_t *self, analyse_form_t form, double sigma, bool third) {
    const double s = 1.0 - (double)lode_one_minus_exp((float)(sigma * self->ts_s));
    return form == ANALYSE_SAMPLED ? pow(s, third ? 3.0 : 2.0) : 1.0;
}

/// Angle per acceleration that is unknown to the PLL: eqs. (27), (28).
static double complex disturbed(const analyse_t *self, analyse_form_t form, bool third,
                                double omega_rad_s) {
    const loop_ratio_t loop = pll(self, form, FIG4_SIGMA, third);
    const double ts = ts_of(self, form);
    // Angle of a rotor that is pushed over whole periods: (1 + n/2)/d^2, n = z - 1, d = n/Ts.
    const double complex n = cexp(I * omega_rad_s * ts) - 1.0;
    const double complex d = ts > 0.0 ? n / ts : I * omega_rad_s;
    const double complex rotor = (1.0 + 0.5 * n) / (d * d);
    return left_over(self, form, FIG4_SIGMA, third) * rotor / (1.0 + loop_at(&loop, omega_rad_s));
}

static void figure4_curves(analyse_t *self) {
    for (int third = 0; third < 2; ++third) {
        for (analyse_form_t form = ANALYSE_THEORY; form <= ANALYSE_SAMPLED; ++form) {
            const char *name = third != 0 ? "LESO-QPLL" : "QPLL";
            analyse_curve_t *curve = analyse_curve(self, "fig4", name, third, form);
            analyse_curve_log(curve, 1.0, top_of(self, form));
            for (int k = 0; k < ANALYSE_POINTS; ++k) {
                curve->value[k] = disturbed(self, form, third != 0, curve->omega_rad_s[k]);
            }
        }
    }
}

static void figure4(analyse_t *self) {
    static const char *const table = "paper 1, Figure 4";
    const double at[] = {20.0, 200.0, 2000.0};
    for (int k = 0; k < 3; ++k) {
        char setting[ANALYSE_TEXT];
        (void)snprintf(setting, sizeof setting, "sigma 200 rad/s, at %g rad/s", at[k]);
        for (int third = 0; third < 2; ++third) {
            analyse_row_t *row = analyse_row(self, table, setting,
                                             third != 0 ? "|angle/acceleration|, LESO-QPLL"
                                                        : "|angle/acceleration|, QPLL",
                                             "dB s^2");
            row->theory = in_dB(disturbed(self, ANALYSE_THEORY, third != 0, at[k]));
            row->sampled = in_dB(disturbed(self, ANALYSE_SAMPLED, third != 0, at[k]));
        }
    }
    figure4_curves(self);
}

/// Final value of the error for an input whose `order`-th derivative is one: 1/(1 + L) over d^order.
static double final_error(const analyse_t *self, analyse_form_t form, bool third, int order) {
    const loop_ratio_t loop = pll(self, form, FIG4_SIGMA, third);
    const polynomial_t sum = polynomial_sum(&loop.top, &loop.bottom);
    // The loop has more integrators than the input, except in one case.
    const double ratio = loop.bottom.c[order] / sum.c[0];
    return loop.bottom.degree > order ? 0.0 : -left_over(self, form, FIG4_SIGMA, third) * ratio;
}

static void table1(analyse_t *self) {
    static const char *const inputs[] = {"step of position", "step of speed", "ramp of speed"};
    for (int order = 0; order < 3; ++order) {
        for (int third = 0; third < 2; ++third) {
            analyse_row_t *row = analyse_row(self, "paper 1, Table 1", inputs[order],
                                             third != 0 ? "error, LESO-QPLL" : "error, QPLL",
                                             order == 2 ? "1e-6 s^2" : "1e-6");
            const bool lags = order == 2 && third == 0; // r/Ki, sigma 200
            row->printed = lags ? 1.0e6 / (FIG4_SIGMA * FIG4_SIGMA) : 0.0;
            row->theory = 1.0e6 * final_error(self, ANALYSE_THEORY, third != 0, order);
            row->sampled = 1.0e6 * final_error(self, ANALYSE_SAMPLED, third != 0, order);
        }
    }
}

// ---- Figure 5 -------------------------------------------------------------------------------------

static loop_ratio_t notch(const analyse_t *self, analyse_form_t form, double centre) {
    return form == ANALYSE_SAMPLED ? loop_notch_sampled(NOTCH_K, centre, self->ts_s)
                                   : loop_notch(NOTCH_K, centre);
}

/// Width between the two frequencies at which the notch attenuates by 3 dB.
static double width_of(const loop_ratio_t *loop, double centre) {
    double edge[2];
    for (int side = 0; side < 2; ++side) {
        double in = centre;
        double out = side == 0 ? 0.1 * centre : 3.0 * centre;
        for (int n = 0; n < 60; ++n) {
            const double middle = 0.5 * (in + out);
            *(cabs(loop_at(loop, middle)) < sqrt(0.5) ? &in : &out) = middle;
        }
        edge[side] = in;
    }
    return edge[1] - edge[0];
}

static void figure5(analyse_t *self) {
    static const char *const table = "paper 1, Figure 5";
    const loop_ratio_t right = notch(self, ANALYSE_THEORY, FIG5_CENTRE);
    const loop_ratio_t sampled = notch(self, ANALYSE_SAMPLED, FIG5_CENTRE);
    analyse_row_t *row = analyse_row(self, table, "600 rad/s, k 0.1", "width at -3 dB", "rad/s");
    row->theory = width_of(&right, FIG5_CENTRE);
    row->sampled = width_of(&sampled, FIG5_CENTRE);
    row = analyse_row(self, table, "600 rad/s, k 0.1", "gain at the centre", "-");
    row->theory = cabs(loop_at(&right, FIG5_CENTRE));
    row->sampled = cabs(loop_at(&sampled, FIG5_CENTRE));
    row = analyse_row(self, table, "600 rad/s, k 0.1", "phase at 300 rad/s", "deg");
    row->theory = rig_deg_from_rad(carg(loop_at(&right, 300.0)));
    row->sampled = rig_deg_from_rad(carg(loop_at(&sampled, 300.0)));
    for (analyse_form_t form = ANALYSE_THEORY; form <= ANALYSE_SAMPLED; ++form) {
        analyse_curve_t *curve = analyse_curve(self, "fig5", "notch, k 0.1", 0, form);
        analyse_curve_log(curve, 100.0, fmin(4000.0, top_of(self, form)));
        for (int k = 0; k < ANALYSE_POINTS; ++k) {
            curve->value[k] =
                loop_at(form == ANALYSE_SAMPLED ? &sampled : &right, curve->omega_rad_s[k]);
        }
    }
}

// ---- Figures 8 and 9, Table 2 -----------------------------------------------------------------------

static loop_ratio_t enhanced(const analyse_t *self, analyse_form_t form, double sigma,
                             double centre) {
    const loop_ratio_t a = notch(self, form, centre);
    const loop_ratio_t b = pll(self, form, sigma, true);
    return loop_product(&a, &b);
}

static double *cell(analyse_row_t *row, analyse_form_t form) {
    return form == ANALYSE_THEORY    ? &row->theory
           : form == ANALYSE_SAMPLED ? &row->sampled
                                     : &row->as_printed;
}

/// Crossover, margin, bandwidth, dominant poles in all forms; `printed` may be NULL.
static void metrics_rows(analyse_t *self, const char *table, const char *setting, double sigma,
                         double centre, const table2_t *printed) {
    analyse_row_t *crossover = analyse_row(self, table, setting, "crossover", "rad/s");
    analyse_row_t *phase = analyse_row(self, table, setting, "phase margin", "deg");
    analyse_row_t *re = analyse_row(self, table, setting, "dominant poles, real part", "rad/s");
    analyse_row_t *im = analyse_row(self, table, setting, "dominant poles, imaginary", "rad/s");
    analyse_row_t *width = analyse_row(self, table, setting, "closed loop, -3 dB", "rad/s");
    for (analyse_form_t form = ANALYSE_THEORY; form <= ANALYSE_AS_PRINTED; ++form) {
        const loop_ratio_t loop = enhanced(self, form, sigma, centre);
        const loop_metrics_t m = loop_metrics(&loop, FROM_rad_s, top_of(self, form));
        const double complex pole = loop_dominant(&loop);
        *cell(crossover, form) = m.crossover_rad_s;
        *cell(phase, form) = m.phase_deg;
        *cell(re, form) = creal(pole);
        *cell(im, form) = cimag(pole);
        *cell(width, form) = m.bandwidth_rad_s;
    }
    if (printed != NULL) {
        crossover->printed = printed->crossover;
        phase->printed = printed->phase;
        re->printed = printed->re;
        im->printed = printed->im;
    }
}

static void loop_curve(analyse_t *self, const char *figure, const char *label, int family,
                       analyse_form_t form, const loop_ratio_t *loop, bool closed) {
    analyse_curve_t *curve = analyse_curve(self, figure, label, family, form);
    analyse_curve_log(curve, FROM_rad_s, top_of(self, form));
    for (int k = 0; k < ANALYSE_POINTS; ++k) {
        const double complex open = loop_at(loop, curve->omega_rad_s[k]);
        curve->value[k] = closed ? open / (1.0 + open) : open;
    }
}

static void figure8(analyse_t *self) {
    for (int n = 0; n < 3; ++n) {
        char setting[ANALYSE_TEXT];
        char label[ANALYSE_TEXT];
        (void)snprintf(setting, sizeof setting, "sigma 100, k 0.1, notch at %g rad/s",
                       fig8_centre[n]);
        (void)snprintf(label, sizeof label, "notch at %g", fig8_centre[n]);
        metrics_rows(self, "paper 1, Figure 8", setting, FIG8_SIGMA, fig8_centre[n], NULL);
        for (analyse_form_t form = ANALYSE_THEORY; form <= ANALYSE_AS_PRINTED; ++form) {
            const loop_ratio_t loop = enhanced(self, form, FIG8_SIGMA, fig8_centre[n]);
            loop_curve(self, "fig8a", label, n, form, &loop, false);
            loop_curve(self, "fig8b", label, n, form, &loop, true);
        }
    }
}

static void note_poles(analyse_t *self, analyse_form_t form, double sigma) {
    double complex poles[MATRIX_MAX];
    const loop_ratio_t loop = enhanced(self, form, sigma, FIG9_CENTRE);
    const int count = loop_poles(&loop, poles);
    for (int k = 0; k < count && self->poles < ANALYSE_POLES_MAX; ++k) {
        self->pole[self->poles++] = (analyse_pole_t){"fig9b", sigma, form, poles[k]};
    }
}

static void figure9(analyse_t *self) {
    for (int n = 0; n < 3; ++n) {
        char setting[ANALYSE_TEXT];
        char label[ANALYSE_TEXT];
        (void)snprintf(setting, sizeof setting, "sigma %g, k 0.1, notch at 600 rad/s",
                       table2[n].sigma);
        (void)snprintf(label, sizeof label, "sigma %g", table2[n].sigma);
        metrics_rows(self, "paper 1, Table 2 and Figure 9", setting, table2[n].sigma, FIG9_CENTRE,
                     &table2[n]);
        for (analyse_form_t form = ANALYSE_THEORY; form <= ANALYSE_AS_PRINTED; ++form) {
            const loop_ratio_t loop = enhanced(self, form, table2[n].sigma, FIG9_CENTRE);
            loop_curve(self, "fig9a", label, n, form, &loop, false);
        }
    }
    for (double sigma = 60.0; sigma < 160.5; sigma += FIG9_SIGMA_STEP) {
        note_poles(self, ANALYSE_THEORY, sigma);
        note_poles(self, ANALYSE_SAMPLED, sigma);
    }
}

void analyse_paper1(analyse_t *self) {
    table1(self);
    figure4(self);
    figure5(self);
    figure8(self);
    figure9(self);
}
