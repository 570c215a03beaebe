#include "report/report_guide.h"

#include <math.h>

#include "config/config_json.h"
#include "config/schema.h"
#include "support/units.h"

// ---- Text -----------------------------------------------------------------------------------------

static void print_rows(FILE *file, const guide_t *guide) {
    (void)fputs(
        "           k2/  damping  slowest | load step  ripple   noise   worst | gain, lowest "
        "speed     gain, rated\n"
        "     k2  sigma            rad/s |       deg     deg  deg rms     sum |   -5   +7    0 "
        "  -1     -5   +7\n",
        file);
    for (int k = 0; k < guide->rows; ++k) {
        const guide_row_t *r = &guide->row[k];
        const bool used = fabs(r->k2_rad_s - guide->used_rad_s) < 1.0e-6 * r->k2_rad_s;
        const bool wanted = fabs(r->k2_rad_s - guide->recommended_rad_s) < 1.0e-6 * r->k2_rad_s;
        (void)fprintf(file,
                      "%7.1f %6.2f %8.3f %8.1f | %9.2f %7.2f %8.3f %7.2f | %4.2f %4.2f %4.2f %4.2f "
                      "  %4.2f %4.2f%s%s%s\n",
                      r->k2_rad_s, r->per_sigma, r->damping, r->slowest_rad_s, r->step_deg,
                      r->ripple_deg, r->noise_deg, r->total_deg, r->fifth_low, r->seventh_low,
                      r->offset, r->negative, r->fifth_high, r->seventh_high,
                      used && guide->adaptive ? "  used" : "", wanted ? "  recommended" : "",
                      r->radius < 1.0 ? "" : "  UNSTABLE");
    }
}

static const char *mark(const rig_config_t *config, const char *key) {
    const int row = rig_schema_find(rig_schema(), "plant", key);
    return config->origin[row].assumed != NULL ? " (assumed)" : "";
}

static void print_guide(FILE *file, const rig_config_t *config, const guide_t *guide) {
    const double np = (double)config->drive.motor.pole_pairs;
    if (guide->rows == 0) {
        (void)fputs("\nFA-LESO: no guideline, because the library would refuse an FA-LESO here\n",
                    file);
        return;
    }
    (void)fprintf(
        file,
        "\nFA-LESO: gain k2, rad/s, with the PLL whose speed tunes it\n"
        "assumed: a load step of %.4g Nm, half the torque at i_max. 5th and 7th harmonic %g%s and "
        "%g%s of the EMF,\nnoise %.3g A rms%s per phase; %.0f .. %.0f rpm, sigma %.1f rad/s. Worst "
        "sum: load step + ripple + 3 noise\n",
        guide->load_Nm, guide->fifth, mark(config, "emf5_ratio"), guide->seventh,
        mark(config, "emf7_ratio"), guide->noise_A, mark(config, "i_noise_A"),
        rig_rpm_from_rad_s(guide->low_rad_s) / np, rig_rpm_from_rad_s(guide->high_rad_s) / np,
        guide->sigma_rad_s);
    print_rows(file, guide);
    if (guide->limit_theory > 0.0) {
        (void)fprintf(
            file,
            "stable for k2 > %.4f sigma (3/4 (sqrt(3) - 1), continuous), %.4f sigma at this "
            "period and sigma\n",
            guide->limit_theory, guide->limit_sampled);
    } else {
        (void)fprintf(file, "stable for every k2 > 0 with the QPLL; at this period too%s\n",
                      guide->limit_sampled > 0.0 ? ": NO" : "");
    }
    (void)fprintf(file,
                  "recommended: %.0f rad/s, the smallest k2 with a damping of 0.45 whose sum is "
                  "within 10 %% of the least\n",
                  guide->recommended_rad_s);
}

static void print_joint_poles(FILE *file, const design_t *design) {
    (void)fputs(
        "\nobserver, PLL and notches as one loop, the PLL's speed fed back: its least damped "
        "pole, rad/s\n"
        "     rpm    sigma            pole   damping\n",
        file);
    for (int k = 0; k < DESIGN_SPEEDS; ++k) {
        const design_speed_t *at = &design->at[k];
        (void)fprintf(file, "%8.1f %8.1f %9.2f%+9.2fj %6.3f%s\n", at->speed_rpm,
                      at->margins.sigma_rad_s, creal(at->pole), fabs(cimag(at->pole)),
                      joint_damping(at->pole), at->radius < 1.0 ? "" : "  UNSTABLE");
    }
}

static void print_sigma(FILE *file, double sigma_rad_s) {
    if (isnan(sigma_rad_s)) {
        (void)fputs("no limit up to w0/5", file);
    } else {
        (void)fprintf(file, "unstable from sigma %.0f rad/s on", sigma_rad_s);
    }
}

static void print_limits(FILE *file, const rig_config_t *config, const limits_t *limits) {
    (void)fprintf(
        file,
        "\nbasis of the limits, with this PLL\n"
        "sigma <= w0/5: %.1f degrees of margin are left with the C-LESO in the loop, none at "
        "%.3f w0;\n               %.1f with a notch of k 0.5 in full at 8 sigma\n",
        limits->w0_margin_deg, limits->sigma_per_w0, limits->w0_margin_notch_deg);
    for (int k = 0; k < LIMITS_NOTCHES; ++k) {
        const limits_notch_t *n = &limits->notch[k];
        (void)fprintf(file,
                      "notch, k %.1f: unstable below %.2f sigma; in full at 6 sigma it would leave "
                      "%.1f degrees,\n              at 8 sigma it leaves %.1f\n",
                      n->k, n->least, n->low_deg, n->high_deg);
    }
    (void)fputs("GI-LESO with the speed fed back: ", file);
    print_sigma(file, limits->gi_sigma_rad_s);
    if (!isnan(limits->gi_omega_rad_s)) {
        (void)fprintf(file, " (at %.0f rpm)",
                      rig_rpm_from_rad_s(limits->gi_omega_rad_s) /
                          (double)config->drive.motor.pole_pairs);
    }
    (void)fputs(";\n         with w_filter_rad_s = 60: ", file);
    print_sigma(file, limits->gi_filtered_rad_s);
    (void)fprintf(file,
                  "\ngeneralised Routh condition (paper 2, Table I): %d of %d random polynomials "
                  "misjudged\n",
                  limits->routh_wrong, limits->routh_cases);
}

void report_guide_text(FILE *file, const rig_config_t *config, const design_t *design) {
    print_joint_poles(file, design);
    print_limits(file, config, &design->limits);
    print_guide(file, config, &design->guide);
}

// ---- JSON -----------------------------------------------------------------------------------------

static void add_row(cJSON *array, const guide_row_t *row) {
    cJSON *item = config_json_item(array);
    config_json_number(item, "k2_rad_s", row->k2_rad_s);
    config_json_number(item, "damping", row->damping);
    config_json_number(item, "radius", row->radius);
    config_json_number(item, "slowest_rad_s", row->slowest_rad_s);
    config_json_number(item, "load_step_deg", row->step_deg);
    config_json_number(item, "ripple_deg", row->ripple_deg);
    config_json_number(item, "noise_deg_rms", row->noise_deg);
    config_json_number(item, "sum_deg", row->total_deg);
    config_json_number(item, "gain_5th_lowest", row->fifth_low);
    config_json_number(item, "gain_7th_lowest", row->seventh_low);
    config_json_number(item, "gain_5th_rated", row->fifth_high);
    config_json_number(item, "gain_7th_rated", row->seventh_high);
    config_json_number(item, "gain_offset_lowest", row->offset);
    config_json_number(item, "gain_negative_lowest", row->negative);
}

static void add_guide(cJSON *root, const guide_t *guide) {
    if (guide->rows == 0) {
        (void)cJSON_AddNullToObject(root, "fa_guideline");
        return;
    }
    cJSON *item = cJSON_AddObjectToObject(root, "fa_guideline");
    (void)cJSON_AddStringToObject(item, "load_step_assumed", "half the torque at i_max");
    config_json_number(item, "sigma_rad_s", guide->sigma_rad_s);
    config_json_number(item, "load_step_Nm", guide->load_Nm);
    config_json_number(item, "emf5_ratio", guide->fifth);
    config_json_number(item, "emf7_ratio", guide->seventh);
    config_json_number(item, "i_noise_A", guide->noise_A);
    config_json_number(item, "k2_per_sigma_limit", guide->limit_theory);
    config_json_number(item, "k2_per_sigma_limit_sampled", guide->limit_sampled);
    config_json_number(item, "k2_recommended_rad_s", guide->recommended_rad_s);
    cJSON *rows = cJSON_AddArrayToObject(item, "rows");
    for (int k = 0; k < guide->rows; ++k) {
        add_row(rows, &guide->row[k]);
    }
}

static void add_limits(cJSON *root, const limits_t *limits) {
    cJSON *item = cJSON_AddObjectToObject(root, "limits");
    config_json_number(item, "margin_at_w0_over_5_deg", limits->w0_margin_deg);
    config_json_number(item, "margin_at_w0_over_5_with_notch_deg", limits->w0_margin_notch_deg);
    config_json_number(item, "sigma_per_w0_without_margin", limits->sigma_per_w0);
    config_json_number(item, "gi_unstable_sigma_rad_s", limits->gi_sigma_rad_s);
    config_json_number(item, "gi_unstable_omega_rad_s", limits->gi_omega_rad_s);
    config_json_number(item, "gi_filtered_unstable_sigma_rad_s", limits->gi_filtered_rad_s);
    config_json_number(item, "routh_cases", limits->routh_cases);
    config_json_number(item, "routh_wrong", limits->routh_wrong);
    cJSON *notches = cJSON_AddArrayToObject(item, "notches");
    for (int k = 0; k < LIMITS_NOTCHES; ++k) {
        cJSON *notch = config_json_item(notches);
        config_json_number(notch, "k", limits->notch[k].k);
        config_json_number(notch, "least_per_sigma", limits->notch[k].least);
        config_json_number(notch, "margin_at_6_sigma_deg", limits->notch[k].low_deg);
        config_json_number(notch, "margin_at_8_sigma_deg", limits->notch[k].high_deg);
    }
}

void report_guide_json(cJSON *root, const design_t *design) {
    add_guide(root, &design->guide);
    add_limits(root, &design->limits);
}
