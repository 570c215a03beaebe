#include "analyse/paper2.h"

#include <math.h>
#include <stdio.h>

#include "support/units.h"

// Paper 2's settings, Table II and the captions of Figs. 1 and 2: Li et al., FA-LESO.
#define SPEED (100.0 * RIG_PI)
#define W0 (500.0 * RIG_PI)
#define KAPPA 2.0
#define WC RIG_PI
#define K1 (10.0 * RIG_PI)
#define K2 (100.0 * RIG_PI)
#define FROM_rad_s (2.0 * RIG_PI)
#define TO_rad_s (4000.0 * RIG_PI)
// Paper 1's, for the table of lags.
#define PAPER1_W0 2000.0

typedef struct {
    lode_emf_kind_t kind;
    double w0, k1, k2;
    double omega_rad_s; ///< tuned to
} filter_t;

static double gain_dB(double complex x) {
    return 20.0 * log10(cabs(x));
}

// ---- The filters ----------------------------------------------------------------------------------

/// Paper 2, Table II: C, GI, FA.
static double complex continuous(const filter_t *f, double omega_rad_s) {
    const double complex s = I * omega_rad_s;
    const double w = f->omega_rad_s;
    if (f->kind == LODE_EMF_FA_LESO) {
        if (!(f->k1 > 0.0)) {
            return f->k2 / (s - I * w + f->k2);
        }
        return (f->k1 + f->k2 * s) / (s * s - I * w * s + f->k1 + f->k2 * s);
    }
    const double w2 = f->w0 * f->w0;
    const double complex g = f->kind == LODE_EMF_GI_LESO
                                 ? 2.0 * KAPPA * w2 * WC * s / (s * s + 2.0 * WC * s + w * w)
                                 : 0.0;
    return (g + w2) / (s * s + 2.0 * f->w0 * s + g + w2);
}

static observer_t sampled_filter(const analyse_t *self, const filter_t *f) {
    const lode_observer_config_t config = {.kind = f->kind,
                                           .w0_rad_s = (float)f->w0,
                                           .gi_kappa = (float)KAPPA,
                                           .gi_wc_rad_s = (float)WC,
                                           .k1_rad2_s2 = (float)f->k1,
                                           .k2_rad_s = (float)f->k2};
    lode_observer_tuning_t tuning;
    if (lode_observer_tune(&tuning, &config, 0.0f, (float)self->ts_s) != LODE_OK) {
        return (observer_t){.modes = 1, .b = {NAN}, .c = {1.0}};
    }
    return observer_make(&tuning, self->ts_s, f->omega_rad_s);
}

static double complex sampled(const analyse_t *self, const filter_t *f, double omega_rad_s) {
    const observer_t o = sampled_filter(self, f);
    return observer_response(&o, cexp(I * omega_rad_s * self->ts_s));
}

static void curves(analyse_t *self, const char *figure, const char *label, int family,
                   const filter_t *f) {
    const double nyquist = 0.999 * RIG_PI / self->ts_s;
    analyse_curve_t *theory = analyse_curve(self, figure, label, family, ANALYSE_THEORY);
    analyse_curve_t *exact = analyse_curve(self, figure, label, family, ANALYSE_SAMPLED);
    const observer_t o = sampled_filter(self, f);
    analyse_curve_two_sided(theory, FROM_rad_s, TO_rad_s);
    analyse_curve_two_sided(exact, FROM_rad_s, fmin(TO_rad_s, nyquist));
    for (int k = 0; k < ANALYSE_POINTS; ++k) {
        theory->value[k] = continuous(f, theory->omega_rad_s[k]);
        exact->value[k] = observer_response(&o, cexp(I * exact->omega_rad_s[k] * self->ts_s));
    }
}

// ---- Figures 1 and 2 --------------------------------------------------------------------------------

static void attenuation(analyse_t *self, const char *table, const char *setting,
                        const filter_t *f) {
    static const char *const names[] = {"gain at 0 (offset)", "gain at -1 (negative sequence)",
                                        "gain at -5", "gain at +7", "gain at 20 times the speed"};
    static const double orders[] = {0.0, -1.0, -5.0, 7.0, 20.0};
    for (int k = 0; k < 5; ++k) {
        analyse_row_t *row = analyse_row(self, table, setting, names[k], "dB");
        row->theory = gain_dB(continuous(f, orders[k] * f->omega_rad_s));
        row->sampled = gain_dB(sampled(self, f, orders[k] * f->omega_rad_s));
    }
    analyse_row_t *row = analyse_row(self, table, setting, "phase at the speed", "deg");
    row->theory = rig_deg_from_rad(carg(continuous(f, f->omega_rad_s)));
    row->sampled = rig_deg_from_rad(carg(sampled(self, f, f->omega_rad_s)));
}

/// Time constant of the slower pole of s^2 + (k2 - j w) s + k1.
static void slow_pole(analyse_t *self, const char *table, const char *setting, const filter_t *f) {
    const double complex half = 0.5 * (f->k2 - I * f->omega_rad_s);
    const double complex root = csqrt(half * half - f->k1);
    const double complex far = -half - (creal(half * conj(root)) < 0.0 ? -root : root);
    const observer_t o = sampled_filter(self, f);
    analyse_row_t *row = analyse_row(self, table, setting, "slower time constant", "s");
    row->theory = -1.0 / creal(f->k1 > 0.0 ? f->k1 / far : far);
    const double z = cabs(o.modes > 1 ? o.a[1][1] : o.a[0][0]);
    row->sampled = -self->ts_s / log(z);
}

static void figures_1_and_2(analyse_t *self) {
    static const double k1s[] = {0.0, 10.0, 100.0, 1000.0};
    static const double k2s[] = {50.0, 100.0, 200.0, 400.0};
    for (int n = 0; n < 4; ++n) {
        char setting[ANALYSE_TEXT];
        char label[ANALYSE_TEXT];
        const filter_t one = {LODE_EMF_FA_LESO, W0, k1s[n] * RIG_PI, K2, SPEED};
        (void)snprintf(label, sizeof label, "k1 = %g pi", k1s[n]);
        (void)snprintf(setting, sizeof setting, "50 Hz, k2 100 pi, k1 %g pi", k1s[n]);
        attenuation(self, "paper 2, Figure 1", setting, &one);
        slow_pole(self, "paper 2, Figure 1", setting, &one);
        curves(self, "li-fig1", label, n, &one);
    }
    for (int n = 0; n < 4; ++n) {
        char setting[ANALYSE_TEXT];
        char label[ANALYSE_TEXT];
        const filter_t two = {LODE_EMF_FA_LESO, W0, K1, k2s[n] * RIG_PI, SPEED};
        (void)snprintf(label, sizeof label, "k2 = %g pi", k2s[n]);
        (void)snprintf(setting, sizeof setting, "50 Hz, k1 10 pi, k2 %g pi", k2s[n]);
        attenuation(self, "paper 2, Figure 2", setting, &two);
        slow_pole(self, "paper 2, Figure 2", setting, &two);
        curves(self, "li-fig2", label, n, &two);
    }
}

// ---- Figure 4 and Table II --------------------------------------------------------------------------

static const struct {
    const char *name;
    lode_emf_kind_t kind;
    double error_deg[3];         ///< measured, Figs. 10 to 12; NaN: "nearly 0"
    double fifth[2], seventh[2]; ///< percent of the EMF at 25 and 50 Hz, Figs. 13 and 14
} observers[] = {
    {"C-LESO", LODE_EMF_C_LESO, {14.0, 23.0, 34.0}, {5.4, 4.1}, {5.9, 4.5}},
    {"GI-LESO", LODE_EMF_GI_LESO, {7.0, 10.0, 12.0}, {3.6, 2.7}, {4.0, 2.9}},
    {"FA-LESO", LODE_EMF_FA_LESO, {0.0, 0.0, 0.0}, {0.8, 0.6}, {0.7, 0.7}},
};

static filter_t of_table_ii(int n, double Hz) {
    return (filter_t){observers[n].kind, W0, K1, K2, 2.0 * RIG_PI * Hz};
}

static void lags_of_table_ii(analyse_t *self, const lode_motor_t *motor) {
    static const double Hz[] = {25.0, 50.0, 70.0};
    for (int f = 0; f < 3; ++f) {
        char setting[ANALYSE_TEXT];
        (void)snprintf(setting, sizeof setting, "Table II's gains, %g Hz", Hz[f]);
        for (int n = 0; n < 3; ++n) {
            const filter_t filter = of_table_ii(n, Hz[f]);
            const double w = filter.omega_rad_s;
            const double complex circuit = observer_circuit(motor, self->ts_s, w);
            analyse_row_t *row =
                analyse_row(self, "paper 2, Figure 4: lag", setting, observers[n].name, "deg");
            row->printed = observers[n].error_deg[f];
            row->theory = -rig_deg_from_rad(carg(continuous(&filter, w)));
            row->sampled = -rig_deg_from_rad(carg(sampled(self, &filter, w) * circuit));
        }
    }
}

/// A harmonic's share of the estimate over the same with the C-LESO.
static double complex share(const analyse_t *self, analyse_form_t form, int n, double Hz,
                            double order) {
    const filter_t f = of_table_ii(n, Hz);
    const double w = f.omega_rad_s;
    return form == ANALYSE_SAMPLED ? sampled(self, &f, order * w) / sampled(self, &f, w)
                                   : continuous(&f, order * w) / continuous(&f, w);
}

static void harmonics_of_table_ii(analyse_t *self) {
    static const double Hz[] = {25.0, 50.0};
    static const char *const names[2][3] = {{"", "5th, GI over C", "5th, FA over C"},
                                            {"", "7th, GI over C", "7th, FA over C"}};
    for (int f = 0; f < 2; ++f) {
        char setting[ANALYSE_TEXT];
        (void)snprintf(setting, sizeof setting, "Table II's gains, %g Hz", Hz[f]);
        for (int n = 1; n < 3; ++n) {
            for (int h = 0; h < 2; ++h) {
                const double order = h == 0 ? -5.0 : 7.0;
                analyse_row_t *row = analyse_row(self, "paper 2, Figures 13 and 14: harmonics",
                                                 setting, names[h][n], "-");
                row->printed = h == 0 ? observers[n].fifth[f] / observers[0].fifth[f]
                                      : observers[n].seventh[f] / observers[0].seventh[f];
                row->theory = cabs(share(self, ANALYSE_THEORY, n, Hz[f], order) /
                                   share(self, ANALYSE_THEORY, 0, Hz[f], order));
                row->sampled = cabs(share(self, ANALYSE_SAMPLED, n, Hz[f], order) /
                                    share(self, ANALYSE_SAMPLED, 0, Hz[f], order));
            }
        }
    }
}

static void figure4(analyse_t *self, const lode_motor_t *motor) {
    for (int n = 0; n < 3; ++n) {
        const filter_t f = of_table_ii(n, 50.0);
        attenuation(self, "paper 2, Figure 4", observers[n].name, &f);
        curves(self, "li-fig4", observers[n].name, n, &f);
    }
    lags_of_table_ii(self, motor);
    harmonics_of_table_ii(self);
}

// ---- Lags -------------------------------------------------------------------------------------------

static double lag_deg(double complex response) {
    return -rig_deg_from_rad(carg(response));
}

/// Paper 1's eq. (11) stepped with forward Euler, no load.
static double complex euler(double w0_Ts, double complex z) {
    const double complex stage = w0_Ts / (z - 1.0 + w0_Ts);
    return z * stage * stage;
}

static void lags(analyse_t *self, const lode_motor_t *motor) {
    static const double rpms[] = {100.0, 300.0, 900.0, 1500.0, 3000.0};
    static const char *const table = "lag before compensation, w0 2000 rad/s, kappa 2";
    for (int n = 0; n < 5; ++n) {
        char setting[ANALYSE_TEXT];
        const double w = rig_rad_s_from_rpm(rpms[n]) * (double)motor->pole_pairs;
        const double complex z = cexp(I * w * self->ts_s);
        const double complex circuit = observer_circuit(motor, self->ts_s, w);
        (void)snprintf(setting, sizeof setting, "%g rpm", rpms[n]);
        for (int k = 0; k < 3; ++k) {
            const filter_t f = {observers[k].kind, PAPER1_W0, 0.0, K2, w};
            analyse_row_t *row = analyse_row(self, table, setting, observers[k].name, "deg");
            row->theory = lag_deg(continuous(&f, w));
            row->sampled = lag_deg(sampled(self, &f, w) * circuit);
            if (k == 0) { // eq. (30)
                row->as_printed =
                    rig_deg_from_rad(atan(2.0 * PAPER1_W0 * w / (PAPER1_W0 * PAPER1_W0 - w * w)));
            }
        }
        analyse_row_t *row = analyse_row(self, table, setting, "C-LESO, forward Euler", "deg");
        row->sampled = lag_deg(euler(PAPER1_W0 * self->ts_s, z) * circuit);
        row = analyse_row(self, table, setting, "C-LESO, predictive form", "deg");
        const filter_t c = {LODE_EMF_C_LESO, PAPER1_W0, 0.0, K2, w};
        row->sampled = lag_deg(sampled(self, &c, w) * circuit / z);
    }
}

void analyse_paper2(analyse_t *self, const lode_motor_t *motor) {
    figures_1_and_2(self);
    figure4(self, motor);
    lags(self, motor);
}
