#include "reproduce/report.h"

#include <math.h>
#include <string.h>

#include "config/config_json.h"
#include "reproduce/verdict.h"

enum { LINE_WIDTH = 138, NOTE_INDENT = 4, REASON_MAX = 2000 };

// ---- Text ---------------------------------------------------------------------------------------

static void print_number(FILE *file, int width, double value, const char *otherwise) {
    if (isnan(value)) {
        (void)fprintf(file, " %*s", width, otherwise);
    } else {
        const int decimals = fabs(value) < 99.95 ? 2 : 1;
        const double shown = fabs(value) < 0.005 ? 0.0 : value; // no -0.00
        (void)fprintf(file, " %*.*f", width, decimals, shown);
    }
}

static void print_claim(FILE *file, const row_t *row) {
    static const char *const marks[] = {"", "~", "~", "<=", ">=", "", ""};
    char text[32] = "-";
    if (row->claim != CLAIM_NONE) {
        (void)snprintf(text, sizeof text, "%s%.4g", marks[row->claim],
                       row->claim == CLAIM_FORMULA ? round(100.0 * row->claimed) / 100.0
                                                   : row->claimed);
    }
    (void)fprintf(file, " %8s", text);
}

/// Line length of the screen.
static int column_width(const table_t *self) {
    return self->paper->shown > 4 ? 9 : 10;
}

static void print_row(FILE *file, const table_t *self, const row_t *row) {
    const judgement_t judgement = verdict_of(self, row);
    (void)fprintf(file, "  %-37s %-5s", row->what, row->unit);
    print_claim(file, row);
    print_number(file, 7, row->theory, "-");
    for (int k = 0; k < self->paper->shown; ++k) {
        print_number(file, column_width(self), row->value[k], row->missing[k]);
    }
    (void)fprintf(file, "  %s", verdict_name(judgement.verdict));
    if (judgement.of > 0) {
        (void)fprintf(file, " (%d of %d)", judgement.held, judgement.of);
    }
    (void)fputc('\n', file);
}

/// Words of `text` until the next space or line end.
static size_t word_length(const char *text) {
    return strcspn(text, " \n");
}

static void print_note(FILE *file, const char *what, const char *note) {
    size_t at = NOTE_INDENT + strlen(what);
    (void)fprintf(file, "%*s%s", NOTE_INDENT, "", what);
    for (; *note != '\0'; ++note) {
        const bool full = *note == ' ' && at + 1 + word_length(note + 1) > LINE_WIDTH;
        if (full || *note == '\n') {
            (void)fprintf(file, "\n%*s", NOTE_INDENT, "");
            at = NOTE_INDENT;
        } else {
            (void)fputc(*note, file);
            at++;
        }
    }
    (void)fputc('\n', file);
}

/// The claims that are not reproduced, row by row: where they hold, the nearest value, or what is missing.
static void print_reasons(FILE *file, const table_t *self, const char *figure) {
    for (int k = 0; k < self->rows; ++k) {
        const row_t *row = &self->row[k];
        char reason[REASON_MAX];
        verdict_reason(self, row, reason, sizeof reason);
        if (strcmp(row->figure, figure) == 0 && reason[0] != '\0') {
            char heading[128];
            (void)snprintf(heading, sizeof heading, "%s, %s: ", row->what,
                           verdict_name(verdict_of(self, row).verdict));
            print_note(file, heading, reason);
        }
    }
}

static void print_bode(FILE *file, const paper_t *paper) {
    (void)fputs("\nBode diagrams, of `analyse --plots FOLDER`:\n ", file);
    for (int k = 0; k < BODE_MAX && paper->bode[k][0] != NULL; ++k) {
        (void)fprintf(file, "%s %s %s", k > 0 ? "," : "", paper->bode[k][0], paper->bode[k][1]);
    }
    (void)fputc('\n', file);
}

/// The number of rows for each verdict.
static void count(const table_t *self, int of[VERDICTS]) {
    for (int v = 0; v < VERDICTS; ++v) {
        of[v] = 0;
    }
    for (int k = 0; k < self->rows; ++k) {
        of[verdict_of(self, &self->row[k]).verdict]++;
    }
}

static void print_summary(FILE *file, const table_t *self) {
    int of[VERDICTS];
    count(self, of);
    (void)fprintf(file,
                  "\n%d claims: %d reproduced, %d contradicted, %d depend on what the paper leaves "
                  "open, %d not comparable; %d more restate tables.\n"
                  "%d variants, seeds %llu to %llu: %u runs, %.0f s of drive\n",
                  of[VERDICT_REPRODUCED] + of[VERDICT_CONTRADICTED] + of[VERDICT_DEPENDS] +
                      of[VERDICT_NOT_COMPARABLE],
                  of[VERDICT_REPRODUCED], of[VERDICT_CONTRADICTED], of[VERDICT_DEPENDS],
                  of[VERDICT_NOT_COMPARABLE], of[VERDICT_IDENTITY], table_variants(self->paper),
                  (unsigned long long)self->first_seed,
                  (unsigned long long)(self->first_seed + (uint64_t)self->seeds - 1u), self->runs,
                  self->simulated_s);
}

void reproduce_report_table(FILE *file, const table_t *self) {
    (void)fputs(self->paper->introduction, file);
    for (int f = 0; f < self->figures; ++f) {
        const figure_t *figure = &self->figure[f];
        (void)fprintf(file, "\n%-45s %8s %7s", figure->title, "claimed", "theory");
        for (int k = 0; k < self->paper->shown; ++k) {
            (void)fprintf(file, " %*s", column_width(self), self->paper->heading[k]);
        }
        (void)fputs("  verdict\n", file);
        for (int k = 0; k < self->rows; ++k) {
            if (strcmp(self->row[k].figure, figure->figure) == 0) {
                print_row(file, self, &self->row[k]);
            }
        }
        if (figure->note[0] != '\0') {
            print_note(file, "", figure->note);
        }
        print_reasons(file, self, figure->figure);
    }
    print_bode(file, self->paper);
    print_summary(file, self);
}

// ---- Files --------------------------------------------------------------------------------------

static const char *const claim_names[] = {"none",     "about",   "size",   "at most",
                                          "at least", "exactly", "formula"};

/// Least and largest of each variant, and in how many of its samples the claim holds.
static void add_variants(cJSON *item, const table_t *self, const row_t *row) {
    cJSON *variants = cJSON_AddArrayToObject(item, "variants");
    for (int v = 0; v < table_variants(self->paper) && row->seeds > 0; ++v) {
        int choice[AXES];
        double low, high;
        (void)table_choices(self->paper, v, choice);
        if (!row->ran[v]) {
            continue;
        }
        cJSON *one = config_json_item(variants);
        for (int k = 0; k < AXES; ++k) {
            if (self->paper->axis[k].choices > 1) {
                (void)cJSON_AddStringToObject(one, self->paper->axis[k].name,
                                              self->paper->axis[k].choice[choice[k]]);
            }
        }
        const bool any = verdict_range(row, v, &low, &high);
        int held = 0;
        int lost = 0;
        for (int s = 0; s < row->seeds; ++s) {
            held += verdict_holds(row, row->sample[v][s]) ? 1 : 0;
            lost += isnan(row->sample[v][s]) ? 1 : 0;
        }
        config_json_number(one, "least", any ? low : NAN);
        config_json_number(one, "largest", any ? high : NAN);
        config_json_number(one, "lost", lost);
        config_json_number(one, "holds", held);
        config_json_number(one, "of", row->seeds);
    }
}

static void add_row(cJSON *array, const table_t *self, const row_t *row) {
    const judgement_t judgement = verdict_of(self, row);
    char reason[REASON_MAX];
    cJSON *item = config_json_item(array);
    verdict_reason(self, row, reason, sizeof reason);
    (void)cJSON_AddStringToObject(item, "id", row->id);
    (void)cJSON_AddStringToObject(item, "figure", row->figure);
    (void)cJSON_AddStringToObject(item, "what", row->what);
    (void)cJSON_AddStringToObject(item, "unit", row->unit);
    (void)cJSON_AddStringToObject(item, "claim", claim_names[row->claim]);
    config_json_number(item, "claimed", row->claimed);
    config_json_number(item, "reading", row->reading);
    config_json_number(item, "theory", row->theory);
    (void)cJSON_AddStringToObject(item, "formula", row->formula != NULL ? row->formula : "");
    for (int k = 0; k < self->paper->columns; ++k) {
        if (isnan(row->value[k]) && row->missing[k][0] != '-') {
            (void)cJSON_AddStringToObject(item, self->paper->key[k], row->missing[k]);
        } else {
            config_json_number(item, self->paper->key[k], row->value[k]);
        }
    }
    (void)cJSON_AddStringToObject(item, "verdict", verdict_name(judgement.verdict));
    config_json_number(item, "held", judgement.held);
    config_json_number(item, "of", judgement.of);
    (void)cJSON_AddStringToObject(item, "why", reason);
    add_variants(item, self, row);
}

void reproduce_report_json(FILE *file, const table_t *self, const rig_config_t *config) {
    cJSON *root = config_json_root();
    (void)cJSON_AddStringToObject(root, "paper", self->paper->reference);
    (void)cJSON_AddStringToObject(root, "method", self->paper->introduction);
    config_json_number(root, "window_s", self->paper->window_s);
    config_json_number(root, "first_seed", (double)self->first_seed);
    config_json_number(root, "seeds", self->seeds);
    config_json_number(root, "runs", self->runs);
    config_json_number(root, "simulated_s", self->simulated_s);
    cJSON *rows = cJSON_AddArrayToObject(root, "rows");
    for (int k = 0; k < self->rows; ++k) {
        add_row(rows, self, &self->row[k]);
    }
    cJSON *figures = cJSON_AddArrayToObject(root, "figures");
    for (int k = 0; k < self->figures; ++k) {
        const figure_t *figure = &self->figure[k];
        cJSON *item = config_json_item(figures);
        (void)cJSON_AddStringToObject(item, "figure", figure->figure);
        (void)cJSON_AddStringToObject(item, "title", figure->title);
        (void)cJSON_AddStringToObject(item, "note", figure->note);
    }
    cJSON *bode = cJSON_AddObjectToObject(root, "bode");
    for (int k = 0; k < BODE_MAX && self->paper->bode[k][0] != NULL; ++k) {
        (void)cJSON_AddStringToObject(bode, self->paper->bode[k][0], self->paper->bode[k][1]);
    }
    (void)cJSON_AddItemToObject(root, "config", config_json(config));
    (void)config_json_write(file, root);
}

static void csv_number(FILE *file, double value, const char *otherwise) {
    if (isnan(value)) {
        (void)fprintf(file, ",%s", otherwise);
    } else {
        (void)fprintf(file, ",%.6g", value);
    }
}

void reproduce_report_csv(FILE *file, const table_t *self) {
    (void)fputs("id,figure,what,unit,claim,claimed,reading,theory", file);
    for (int k = 0; k < self->paper->columns; ++k) {
        (void)fprintf(file, ",%s", self->paper->key[k]);
    }
    (void)fputs(",verdict,held,of\n", file);
    for (int k = 0; k < self->rows; ++k) {
        const row_t *row = &self->row[k];
        const judgement_t judgement = verdict_of(self, row);
        (void)fprintf(file, "%s,%s,\"%s\",%s,%s", row->id, row->figure, row->what, row->unit,
                      claim_names[row->claim]);
        csv_number(file, row->claimed, "");
        csv_number(file, row->reading, "");
        csv_number(file, row->theory, "");
        for (int c = 0; c < self->paper->columns; ++c) {
            csv_number(file, row->value[c], row->missing[c][0] != '-' ? row->missing[c] : "");
        }
        (void)fprintf(file, ",%s,%d,%d\n", verdict_name(judgement.verdict), judgement.held,
                      judgement.of);
    }
}
