#include "reproduce/li_rows.h"
#include "reproduce/li_work.h"

#include <math.h>
#include <stdio.h>

#include "support/units.h"

// ---- Tables -------------------------------------------------------------------------------------

static void table_1(li_work_t *work) {
    const li_theory_t *t = &work->theory;
    figure_t *figure = table_figure(work->table, "table1", "Table I: stability for k1, k2 > 0");
    (void)snprintf(
        figure->note, sizeof figure->note,
        "For 8 values of k1 (1e-3 to 1e4), 9 of k2 (1 to 1e4, either sign) and 5 speeds (0 to 1e4 "
        "rad/s), the roots of eq. 22 lie in the left half-plane exactly where eq. 24 says so. In "
        "forward Euler, eqs. 27 and 28 are stable only up to the speed in the second row.");
    int wrong = 0;
    for (int n = 0; n < 8 * 9 * 5 * 2; ++n) {
        const double k1 = pow(10.0, n % 8 - 3.0);
        const double k2 = pow(10.0, 0.5 * (n / 8 % 9)) * (n / 360 == 0 ? 1.0 : -1.0);
        const double w = 2500.0 * (n / 72 % 5);
        wrong += (li_theory_slowest(k1, k2, w) < 0.0) != (k2 > 0.0) ? 1 : 0;
    }
    const words_t words = {
        .claim = CLAIM_FORMULA, .claimed = 0.0, .theory = wrong, .formula = "eq. 24"};
    row_t *row = table_row(work->table, "table1", "table1_routh",
                           "eq. 24: wrong verdicts in 720 cases", "", &words);
    row->value[LI_PRINTED] = wrong;
    const words_t none = table_no_claim(NAN, NULL);
    row = table_row(work->table, "table1", "table1_euler", "FA-LESO: stable up to", "Hz", &none);
    row->value[LI_PRINTED] = li_theory_euler_limit_Hz(t);
    row->missing[LI_EXACT] = row->missing[LI_UNCOMPENSATED] = "any";
}

static void table_2(li_work_t *work) {
    const li_theory_t *t = &work->theory;
    static const double claimed[LI_OBSERVERS] = {1.0, 1.0, 1.0}; // eqs. 36, 37, 38
    const double w = li_theory_rad_s(t, 600.0);
    figure_t *figure = table_figure(work->table, "table2", "Table II: transfer functions at 50 Hz");
    (void)snprintf(figure->note, sizeof figure->note,
                   "From the EMF at t_k to its estimate at t_k. Theory: eqs. 17, 29, 26. Printed: "
                   "the same in forward Euler at 10 kHz. Exact raw: the library's form. Eqs. 36 to "
                   "38 claim a gain of 1 for all three; that of the C-LESO is %.1f %% smaller. "
                   "|G(jw)| in eq. 37 is not infinite but Kr = 2 w0^2, so the GI-LESO keeps a lag. "
                   "The sampled FA-LESO is off by half a period, w Ts/2. It leads in forward Euler "
                   "and lags in the library's form, which compensates the lag.",
                   100.0 * (1.0 - cabs(li_theory_printed(t, LI_C, w, w))));
    for (int o = 0; o < LI_OBSERVERS; ++o) {
        const li_observer_t observer = (li_observer_t)o;
        char id[48];
        char what[64];
        const words_t gain = {.claim = CLAIM_FORMULA,
                              .claimed = claimed[o],
                              .theory = cabs(li_theory_printed(t, observer, w, w)),
                              .formula = "|H(jw)|"};
        (void)snprintf(id, sizeof id, "table2_%s_gain", li_names[o]);
        (void)snprintf(what, sizeof what, "%s: gain", li_observers[o]);
        row_t *row = table_row(work->table, "table2", id, what, "", &gain);
        row->value[LI_PRINTED] = cabs(li_theory_euler(t, observer, w, w));
        row->value[LI_UNCOMPENSATED] = cabs(li_theory_exact(t, observer, w, w));
        const words_t phase =
            table_no_claim(li_phase_deg(li_theory_printed(t, observer, w, w)), "arg H(jw)");
        (void)snprintf(id, sizeof id, "table2_%s_phase", li_names[o]);
        (void)snprintf(what, sizeof what, "%s: phase", li_observers[o]);
        row = table_row(work->table, "table2", id, what, "deg", &phase);
        row->value[LI_PRINTED] = li_phase_deg(li_theory_euler(t, observer, w, w));
        row->value[LI_UNCOMPENSATED] = li_phase_deg(li_theory_exact(t, observer, w, w));
    }
}

// ---- Fig. 4: noise, order -----------------------------------------------------------------------

#define FIRST_Hz 150.0
#define STEP_Hz 1.0

/// The frequency, of either sign, up to which noise has less of an effect than with the C-LESO, Hz.
static double below_C_up_to(const li_theory_t *t, li_form_t form, double tuned) {
    const double last_Hz = 0.5 / t->euler.ts_s;
    for (double f = FIRST_Hz; f < last_Hz; f += STEP_Hz) {
        for (int sign = -1; sign <= 1; sign += 2) {
            const double w = 2.0 * RIG_PI * f * sign;
            if (li_theory_noise(t, form, LI_FA, w, tuned) >
                li_theory_noise(t, form, LI_C, w, tuned)) {
                return f;
            }
        }
    }
    return last_Hz;
}

static void form_row(li_work_t *work, const char *id, const char *what, const char *unit,
                     const words_t *words, const double value[LI_FORMS]) {
    row_t *row = table_row(work->table, "fig4", id, what, unit, words);
    row->value[LI_PRINTED] = value[LI_EULER];
    row->value[LI_UNCOMPENSATED] = value[LI_SAMPLED];
    row->seeds = 1;
    for (int form = 0; form < LI_FORMS; ++form) {
        const int v = table_variant(work->table->paper, (const int[AXES]){form, 0, 0});
        row->ran[v] = true;
        row->sample[v][0] = value[form];
    }
}

static void figure_4(li_work_t *work) {
    const li_theory_t *t = &work->theory;
    const double tuned = li_theory_rad_s(t, 600.0);
    const double last_Hz = 0.5 / t->euler.ts_s;
    figure_t *figure = table_figure(work->table, "fig4", "Fig. 4: noise, order; 50 Hz, Table II");
    (void)snprintf(
        figure->note, sizeof figure->note,
        "\"Better noise immunity than C-LESO and GI-LESO\" is tested with white noise of the "
        "sampled currents. We compare its effect on the EMF at each frequency up to half the PWM "
        "frequency, %.0f Hz (from %.0f Hz on, because the speed itself is meant to pass), and the "
        "variance of this effect. \"Continuous\" is the printed transfer function.",
        last_Hz, FIRST_Hz);
    double up_to[LI_FORMS], over_C[LI_FORMS], over_GI[LI_FORMS];
    for (int form = 0; form < LI_FORMS; ++form) {
        const double fa = li_theory_noise_variance(t, (li_form_t)form, LI_FA, tuned);
        up_to[form] = below_C_up_to(t, (li_form_t)form, tuned);
        over_C[form] = fa / li_theory_noise_variance(t, (li_form_t)form, LI_C, tuned);
        over_GI[form] = fa / li_theory_noise_variance(t, (li_form_t)form, LI_GI, tuned);
    }
    const words_t band = {.claim = CLAIM_AT_LEAST,
                          .claimed = last_Hz,
                          .theory = up_to[LI_CONTINUOUS],
                          .formula = "|H(jw)| of both"};
    form_row(work, "fig4_below_c", "FA-LESO below C-LESO up to", "Hz", &band, up_to);
    const words_t c = {.claim = CLAIM_AT_MOST, .claimed = 1.0, .theory = NAN};
    form_row(work, "fig4_variance_c", "variance, FA over C-LESO", "", &c, over_C);
    form_row(work, "fig4_variance_gi", "variance, FA over GI-LESO", "", &c, over_GI);
    static const double claimed[LI_OBSERVERS] = {2.0, 4.0, 2.0};
    for (int o = 0; o < LI_OBSERVERS; ++o) {
        char id[48];
        char what[64];
        const words_t order = {.claim = CLAIM_FORMULA,
                               .claimed = claimed[o],
                               .theory = o == LI_GI ? 4.0 : 2.0,
                               .formula = "degree of the denominator"};
        (void)snprintf(id, sizeof id, "order_%s", li_names[o]);
        (void)snprintf(what, sizeof what, "%s: order", li_observers[o]);
        (void)table_row(work->table, "fig4", id, what, "", &order);
    }
}

void li_tables(li_work_t *work) {
    table_1(work);
    table_2(work);
    figure_4(work);
}
