#include "reproduce_report.h"

#include <math.h>
#include <string.h>

#include "config_json.h"

#include "lodestar/version.h"

// ---- Text ---------------------------------------------------------------------------------------

static const char introduction[] =
    "Jiang et al., Energies 2022, 15, 1943, Section 5, on the simulated machine of its Table 3: 5 "
    "kHz, "
    "200 V, 4 us dead\ntime, the paper's gains, id* = 0. Ours, as the paper does not give it: "
    "drops of "
    "1 V + 0.05 Ohm, 12 bit, noise, ramps.\n\n"
    "as printed   forward Euler; eq. 30 in the enhanced PLL, no compensation in the QPLL; no "
    "dead-time "
    "correction\n"
    "exact        the library's estimator in its place, with exact compensation\n"
    "corrected    the same with the EMF of the active flux, and dead-time correction\n"
    "own gains    what the library designs by itself: id bias at low speed, sigma by speed, "
    "supervision\n"
    "             of the lock, which in the others is slowed down until it stays out, as the paper "
    "has none\n"
    "theory       of what is printed, in closed form\n\n"
    "Every chain is seeded at the true angle and speed at t = 0 of its experiment, after a start "
    "with "
    "an encoder. Angles\nelectrical, estimate - truth; steady: the last 0.4 s; deviation: largest "
    "|error - mean before|. \"lost\": more than 90 deg\noff; \"stalls\": the largest current does "
    "not "
    "hold the speed. A claim \"~\" is met within 30 % or 1.5 units.\n";

static void print_number(FILE *file, int width, double value, const char *otherwise) {
    if (isnan(value)) {
        (void)fprintf(file, " %*s", width, otherwise);
    } else {
        const int decimals = fabs(value) < 99.95 ? 2 : 1;
        (void)fprintf(file, " %*.*f", width, decimals, value);
    }
}

static void print_claim(FILE *file, const row_t *row) {
    static const char *const marks[] = {"", "~", "~", "<=", "", ""};
    char text[32] = "-";
    if (row->claim != CLAIM_NONE) {
        (void)snprintf(text, sizeof text, "%s%g", marks[row->claim],
                       row->claim == CLAIM_EXACTLY ? round(100.0 * row->claimed) / 100.0
                                                   : row->claimed);
    }
    (void)fprintf(file, " %8s", text);
}

static void print_row(FILE *file, const row_t *row) {
    char verdict[48];
    row_verdict(row, verdict, sizeof verdict);
    (void)fprintf(file, "  %-38s %-5s", row->what, row->unit);
    print_claim(file, row);
    print_number(file, 8, row->theory, "-");
    for (int chain = CHAIN_PRINTED; chain <= CHAIN_LIBRARY; ++chain) {
        print_number(file, 10, row->value[chain], row->missing[chain]);
    }
    (void)fprintf(file, "  %s\n", verdict);
}

static void print_note(FILE *file, const char *what, const char *note) {
    (void)fprintf(file, "    %s", what);
    for (const char *at = note; *at != '\0'; ++at) {
        (void)fputc(*at, file);
        if (*at == '\n') {
            (void)fputs("    ", file);
        }
    }
    (void)fputc('\n', file);
}

static bool is_contradicted(const row_t *row) {
    char verdict[48];
    row_verdict(row, verdict, sizeof verdict);
    return strncmp(verdict, "contradicted", strlen("contradicted")) == 0;
}

/// Why claims do not hold: each reason once, with the rows it is for.
static void print_reasons(FILE *file, const reproduction_t *self, const char *figure) {
    for (int k = 0; k < self->rows; ++k) {
        const row_t *row = &self->row[k];
        bool said = row->why[0] == '\0';
        for (int i = 0; i < k; ++i) {
            const row_t *before = &self->row[i];
            said = said || (strcmp(before->figure, figure) == 0 && is_contradicted(before) &&
                            strcmp(before->why, row->why) == 0);
        }
        if (strcmp(row->figure, figure) == 0 && is_contradicted(row) && !said) {
            print_note(file, "contradicted: ", row->why);
        }
    }
}

void reproduce_report_table(FILE *file, const reproduction_t *reproduction) {
    (void)fputs(introduction, file);
    for (int f = 0; f < reproduction->figures; ++f) {
        const figure_t *figure = &reproduction->figure[f];
        (void)fprintf(file, "\n%-46s %8s %8s %10s %10s %10s %10s  verdict\n", figure->title,
                      "claimed", "theory", "as printed", "exact", "corrected", "own gains");
        for (int k = 0; k < reproduction->rows; ++k) {
            if (strcmp(reproduction->row[k].figure, figure->figure) == 0) {
                print_row(file, &reproduction->row[k]);
            }
        }
        if (figure->note[0] != '\0') {
            print_note(file, "", figure->note);
        }
        print_reasons(file, reproduction, figure->figure);
    }
    int count[2][2] = {{0, 0}, {0, 0}};
    int claims = 0;
    for (int k = 0; k < reproduction->rows; ++k) {
        char verdict[48];
        const row_t *row = &reproduction->row[k];
        row_verdict(row, verdict, sizeof verdict);
        claims += row->claim != CLAIM_NONE ? 1 : 0;
        count[is_contradicted(row) ? 1 : 0][strstr(verdict, "improved") != NULL ? 1 : 0] +=
            row->claim != CLAIM_NONE ? 1 : 0;
    }
    (void)fprintf(
        file,
        "\n%d claims: %d reproduced (%d of them improved), %d contradicted (%d improved). "
        "%u runs, %.0f s of drive\n",
        claims, count[0][0] + count[0][1], count[0][1], count[1][0] + count[1][1], count[1][1],
        reproduction->runs, reproduction->simulated_s);
}

// ---- Files --------------------------------------------------------------------------------------

static const char *const chain_keys[CHAINS] = {
    [CHAIN_PRINTED] = "as_printed",
    [CHAIN_EXACT] = "exact",
    [CHAIN_CORRECTED] = "corrected",
    [CHAIN_LIBRARY] = "own_gains",
    [CHAIN_PRINTED_CORRECTED] = "as_printed_dead_time_corrected",
    [CHAIN_EQ14] = "as_printed_speed_of_eq14",
};
static const char *const claim_names[] = {"none", "about", "size", "at most", "exactly", "formula"};

static void add_row(cJSON *array, const row_t *row) {
    char verdict[48];
    cJSON *item = cJSON_CreateObject();
    (void)cJSON_AddItemToArray(array, item);
    row_verdict(row, verdict, sizeof verdict);
    (void)cJSON_AddStringToObject(item, "id", row->id);
    (void)cJSON_AddStringToObject(item, "figure", row->figure);
    (void)cJSON_AddStringToObject(item, "what", row->what);
    (void)cJSON_AddStringToObject(item, "unit", row->unit);
    (void)cJSON_AddStringToObject(item, "claim", claim_names[row->claim]);
    config_json_number(item, "claimed", row->claimed);
    config_json_number(item, "theory", row->theory);
    (void)cJSON_AddStringToObject(item, "formula", row->formula != NULL ? row->formula : "");
    for (int chain = 0; chain < CHAINS; ++chain) {
        if (isnan(row->value[chain]) && row->missing[chain][0] != '-') {
            (void)cJSON_AddStringToObject(item, chain_keys[chain], row->missing[chain]);
        } else {
            config_json_number(item, chain_keys[chain], row->value[chain]);
        }
    }
    (void)cJSON_AddStringToObject(item, "verdict", verdict);
    (void)cJSON_AddStringToObject(item, "why", is_contradicted(row) ? row->why : "");
}

void reproduce_report_json(FILE *file, const reproduction_t *reproduction,
                           const case_bases_t *bases) {
    cJSON *root = cJSON_CreateObject();
    char version[32];
    (void)snprintf(version, sizeof version, "%d.%d.%d", LODE_VERSION_MAJOR, LODE_VERSION_MINOR,
                   LODE_VERSION_PATCH);
    (void)cJSON_AddStringToObject(root, "lodestar", version);
    (void)cJSON_AddStringToObject(root, "paper", "Energies 2022, 15, 1943");
    (void)cJSON_AddStringToObject(root, "method", introduction);
    config_json_number(root, "window_s", CASE_WINDOW_s);
    config_json_number(root, "runs", reproduction->runs);
    config_json_number(root, "simulated_s", reproduction->simulated_s);
    cJSON *rows = cJSON_AddArrayToObject(root, "rows");
    for (int k = 0; k < reproduction->rows; ++k) {
        add_row(rows, &reproduction->row[k]);
    }
    cJSON *notes = cJSON_AddObjectToObject(root, "derivations");
    for (int k = 0; k < reproduction->figures; ++k) {
        const figure_t *figure = &reproduction->figure[k];
        (void)cJSON_AddStringToObject(notes, figure->figure, figure->note);
    }
    (void)cJSON_AddItemToObject(root, "config", config_json(&bases->paper));
    (void)config_json_write(file, root);
}

static void csv_number(FILE *file, double value, const char *otherwise) {
    if (isnan(value)) {
        (void)fprintf(file, ",%s", otherwise);
    } else {
        (void)fprintf(file, ",%.6g", value);
    }
}

void reproduce_report_csv(FILE *file, const reproduction_t *reproduction) {
    (void)fputs("id,figure,what,unit,claim,claimed,theory", file);
    for (int chain = 0; chain < CHAINS; ++chain) {
        (void)fprintf(file, ",%s", chain_keys[chain]);
    }
    (void)fputs(",verdict\n", file);
    for (int k = 0; k < reproduction->rows; ++k) {
        const row_t *row = &reproduction->row[k];
        char verdict[48];
        row_verdict(row, verdict, sizeof verdict);
        (void)fprintf(file, "%s,%s,\"%s\",%s,%s", row->id, row->figure, row->what, row->unit,
                      claim_names[row->claim]);
        csv_number(file, row->claimed, "");
        csv_number(file, row->theory, "");
        for (int chain = 0; chain < CHAINS; ++chain) {
            csv_number(file, row->value[chain],
                       row->missing[chain][0] != '-' ? row->missing[chain] : "");
        }
        (void)fprintf(file, ",\"%s\"\n", verdict);
    }
}
