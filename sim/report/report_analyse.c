#include "report/report_analyse.h"

#include <math.h>
#include <string.h>

#include "config/assumptions.h"
#include "config/config_json.h"
#include "support/units.h"

static const char *const forms[] = {"theory", "sampled", "as printed"};

// ---- Text -----------------------------------------------------------------------------------------

/// About four digits.
static int digits_for(double size) {
    int digits = 3;
    for (double limit = 10.0; digits > 0 && size >= limit; limit *= 10.0) {
        --digits;
    }
    return digits;
}

static void print_cell(FILE *file, double value) {
    if (isfinite(value)) {
        const double size = fabs(value);
        // No sign on what rounds to zero.
        (void)fprintf(file, " %11.*f", digits_for(size), size < 0.5e-3 ? 0.0 : value);
    } else {
        (void)fprintf(file, " %11s", isnan(value) ? "-" : value > 0.0 ? "inf" : "-inf");
    }
}

/// Notes on the tables, by the beginning of their names.
static const char *note_on(const char *table) {
    static const struct {
        const char *table, *note;
    } notes[] = {
        {"paper 1, Table 1",
         "sigma 200 rad/s, for one unit of position, speed, acceleration. By its own "
         "eqs. (24), (26)\nthe paper's r/Ki lacks a minus sign."},
        {"paper 1, Figure 4",
         "By eqs. (27), (28) the LESO-QPLL is better by w/|jw + sigma| at every "
         "frequency."},
        {"paper 1, Figure 8",
         "\"Crossovers and margins are almost the same\": so they are, with the "
         "corrected open loop."},
        {"paper 1, Table 2",
         "Misprint: eqs. (35), (36) have (s + sigma)^3/s^3. By eq. (21) the open "
         "loop is\nnotch * ((s + sigma)^3 - s^3)/s^3, and only that gives Table 2. "
         "The notch is in full here;\nthe firmware blends it in from 6 to 8 sigma."},
        {"paper 2, Figure 1",
         "Gains in alpha-beta by order of the speed. The values of k1 are ours; the "
         "paper's text\nnames none. k1 > 0 passes the offset with gain 1."},
        {"paper 2, Figure 2", "The values of k2 are ours; the paper's text names none."},
        {"paper 2, Figure 4: lag",
         "Printed: mean position errors of its Figs. 10 to 12 (\"nearly 0\" for "
         "FA). Sampled: with\nthe half period that the firmware also "
         "compensates."},
        {"paper 2, Figures 13",
         "Printed: ratios of its measured harmonics. With Table II's k2 the FA-LESO "
         "cannot\nattenuate that much."},
    };
    for (size_t k = 0; k < sizeof notes / sizeof notes[0]; ++k) {
        if (strncmp(table, notes[k].table, strlen(notes[k].table)) == 0) {
            return notes[k].note;
        }
    }
    return NULL;
}

static void print_rows(FILE *file, const analyse_t *analysis) {
    const char *table = "";
    const char *setting = "";
    for (int k = 0; k < analysis->rows; ++k) {
        const analyse_row_t *row = &analysis->row[k];
        if (strcmp(row->table, table) != 0) {
            table = row->table;
            setting = "";
            (void)fprintf(file, "\n%s\n%-34s %8s %11s %11s %11s %11s\n", table, "", "unit", "paper",
                          "as printed", "theory", "sampled");
        }
        if (strcmp(row->setting, setting) != 0) {
            setting = row->setting;
            (void)fprintf(file, "%s\n", setting);
        }
        (void)fprintf(file, "  %-32s %8s", row->quantity, row->unit);
        print_cell(file, row->printed);
        print_cell(file, row->as_printed);
        print_cell(file, row->theory);
        print_cell(file, row->sampled);
        (void)fputc('\n', file);
        const bool ends = k == analysis->rows - 1 || strcmp(analysis->row[k + 1].table, table) != 0;
        if (ends && note_on(table) != NULL) {
            (void)fprintf(file, "%s\n", note_on(table));
        }
    }
}

static void print_speeds(FILE *file, const analyse_t *analysis) {
    (void)fputs("\nthis drive: observer before compensation, margins of the PLL with it\n"
                "     rpm   lag deg  firmware   |e^/e|    sigma  margin alone  margin\n",
                file);
    for (int k = 0; k < ANALYSE_SPEEDS; ++k) {
        const analyse_speed_t *at = &analysis->at[k];
        (void)fprintf(file, "%8.1f %9.3f %9.3f %8.4f %8.1f %13.1f %7.1f\n", at->speed_rpm,
                      at->lag_deg, at->lag_firmware_deg, at->gain, at->margins.sigma_rad_s,
                      at->margins.phase_alone_deg, at->margins.phase_deg);
    }
    (void)fputs("\nthis drive: closed-loop poles of observer, PLL and notches, ln(z)/Ts in rad/s, "
                "least damped first\n",
                file);
    for (int k = 0; k < ANALYSE_SPEEDS; ++k) {
        const analyse_speed_t *at = &analysis->at[k];
        (void)fprintf(file, "%8.1f rpm:", at->speed_rpm);
        for (int n = 0; n < at->poles; ++n) {
            // Only the upper pole of a pair.
            if (cimag(at->pole[n]) > -1.0e-6 * cabs(at->pole[n])) {
                (void)fprintf(file,
                              cimag(at->pole[n]) > 1.0e-6 * cabs(at->pole[n]) ? " %.2f+-%.2fj"
                                                                              : " %.2f",
                              creal(at->pole[n]), cimag(at->pole[n]));
            }
        }
        (void)fputc('\n', file);
    }
}

static void print_loops(FILE *file, const analyse_t *analysis) {
    (void)fputs(
        "\nthis drive: margins of its loops, sampled; the speed loop without the feed-forwards "
        "of load and inertia\n"
        "loop                       rpm  crossover  margin  gain up\n"
        "                                    rad/s     deg       dB\n",
        file);
    for (int k = 0; k < analysis->loops; ++k) {
        const analyse_loop_t *loop = &analysis->loop[k];
        (void)fprintf(file, "%-22s", loop->name);
        if (isnan(loop->speed_rpm)) {
            (void)fprintf(file, "%8s", "any");
        } else {
            (void)fprintf(file, "%8.1f", loop->speed_rpm);
        }
        (void)fprintf(file, "%11.1f %7.1f", loop->crossover_rad_s, loop->phase_deg);
        if (isnan(loop->gain_dB)) {
            (void)fprintf(file, " %8s\n", "-");
        } else {
            (void)fprintf(file, " %8.1f\n", loop->gain_dB);
        }
    }
}

void report_analyse_text(FILE *file, const rig_config_t *config, const analyse_t *analysis) {
    assumptions_print(file, config, "");
    (void)fprintf(file,
                  "sampled: the firmware's coefficients at %g Hz. paper: the figure it prints. as "
                  "printed: its formula,\ntaken literally. theory: the continuous formula, "
                  "corrected.\n",
                  (double)config->drive.f_pwm_Hz);
    print_rows(file, analysis);
    print_speeds(file, analysis);
    print_loops(file, analysis);
}

// ---- CSV ------------------------------------------------------------------------------------------

void report_analyse_csv(FILE *file, const analyse_t *analysis) {
    (void)fputs("figure,curve,form,omega_rad_s,gain_dB,phase_deg\n", file);
    for (int c = 0; c < analysis->curves; ++c) {
        const analyse_curve_t *curve = &analysis->curve[c];
        for (int k = 0; k < ANALYSE_POINTS; ++k) {
            (void)fprintf(file, "%s,\"%s\",%s,%.9g,%.9g,%.9g\n", curve->figure, curve->label,
                          forms[curve->form], curve->omega_rad_s[k],
                          20.0 * log10(fmax(cabs(curve->value[k]), 1.0e-10)),
                          rig_deg_from_rad(carg(curve->value[k])));
        }
    }
}

// ---- JSON -----------------------------------------------------------------------------------------

static void add_row(cJSON *array, const analyse_row_t *row) {
    cJSON *item = config_json_item(array);
    (void)cJSON_AddStringToObject(item, "table", row->table);
    (void)cJSON_AddStringToObject(item, "setting", row->setting);
    (void)cJSON_AddStringToObject(item, "quantity", row->quantity);
    (void)cJSON_AddStringToObject(item, "unit", row->unit);
    config_json_number(item, "printed", row->printed);
    config_json_number(item, "as_printed", row->as_printed);
    config_json_number(item, "theory", row->theory);
    config_json_number(item, "sampled", row->sampled);
}

static void add_speed(cJSON *array, const analyse_speed_t *at) {
    cJSON *item = config_json_item(array);
    config_json_number(item, "speed_rpm", at->speed_rpm);
    config_json_number(item, "omega_e_rad_s", at->omega_rad_s);
    config_json_number(item, "lag_deg", at->lag_deg);
    config_json_number(item, "lag_firmware_deg", at->lag_firmware_deg);
    config_json_number(item, "gain", at->gain);
    config_json_number(item, "phase_margin_deg", at->margins.phase_deg);
    cJSON *poles = cJSON_AddArrayToObject(item, "poles");
    for (int k = 0; k < at->poles; ++k) {
        const double parts[] = {creal(at->pole[k]), cimag(at->pole[k])};
        (void)cJSON_AddItemToArray(poles, cJSON_CreateDoubleArray(parts, 2));
    }
}

static void add_loop(cJSON *array, const analyse_loop_t *loop) {
    cJSON *item = cJSON_CreateObject();
    (void)cJSON_AddItemToArray(array, item);
    (void)cJSON_AddStringToObject(item, "loop", loop->name);
    config_json_number(item, "speed_rpm", loop->speed_rpm);
    config_json_number(item, "crossover_rad_s", loop->crossover_rad_s);
    config_json_number(item, "phase_margin_deg", loop->phase_deg);
    config_json_number(item, "gain_margin_dB", loop->gain_dB);
}

void report_analyse_json(FILE *file, const rig_config_t *config, const analyse_t *analysis) {
    cJSON *root = config_json_root();
    cJSON *rows = cJSON_AddArrayToObject(root, "figures");
    for (int k = 0; k < analysis->rows; ++k) {
        add_row(rows, &analysis->row[k]);
    }
    cJSON *speeds = cJSON_AddArrayToObject(root, "speeds");
    for (int k = 0; k < ANALYSE_SPEEDS; ++k) {
        add_speed(speeds, &analysis->at[k]);
    }
    cJSON *loops = cJSON_AddArrayToObject(root, "loops");
    for (int k = 0; k < analysis->loops; ++k) {
        add_loop(loops, &analysis->loop[k]);
    }
    (void)cJSON_AddItemToObject(root, "assumed", config_json_assumed(config));
    (void)cJSON_AddItemToObject(root, "config", config_json(config));
    (void)config_json_write(file, root);
}
