#include "reproduce/report.h"

#include <math.h>
#include <string.h>

#include "config/config_json.h"

enum { LINE_WIDTH = 138, NOTE_INDENT = 4 };

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
    static const char *const marks[] = {"", "~", "~", "<=", "", ""};
    char text[32] = "-";
    if (row->claim != CLAIM_NONE) {
        (void)snprintf(text, sizeof text, "%s%.4g", marks[row->claim],
                       row->claim == CLAIM_EXACTLY ? round(100.0 * row->claimed) / 100.0
                                                   : row->claimed);
    }
    (void)fprintf(file, " %8s", text);
}

/// Lines shall fit on a screen.
static int column_width(const table_t *self) {
    return self->paper->shown > 4 ? 9 : 10;
}

static void print_row(FILE *file, const table_t *self, const row_t *row) {
    char verdict[48];
    table_verdict(self, row, verdict, sizeof verdict);
    (void)fprintf(file, "  %-38s %-5s", row->what, row->unit);
    print_claim(file, row);
    print_number(file, 8, row->theory, "-");
    for (int k = 0; k < self->paper->shown; ++k) {
        print_number(file, column_width(self), row->value[k], row->missing[k]);
    }
    (void)fprintf(file, "  %s\n", verdict);
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

static bool is_contradicted(const table_t *self, const row_t *row) {
    char verdict[48];
    table_verdict(self, row, verdict, sizeof verdict);
    return strncmp(verdict, "contradicted", strlen("contradicted")) == 0;
}

/// Why claims do not hold: each reason once, with the rows it is for.
static void print_reasons(FILE *file, const table_t *self, const char *figure) {
    for (int k = 0; k < self->rows; ++k) {
        const row_t *row = &self->row[k];
        bool said = row->why[0] == '\0';
        for (int i = 0; i < k; ++i) {
            const row_t *before = &self->row[i];
            said = said || (strcmp(before->figure, figure) == 0 && is_contradicted(self, before) &&
                            strcmp(before->why, row->why) == 0);
        }
        if (strcmp(row->figure, figure) == 0 && is_contradicted(self, row) && !said) {
            print_note(file, "contradicted: ", row->why);
        }
    }
}

void reproduce_report_table(FILE *file, const table_t *self) {
    (void)fputs(self->paper->introduction, file);
    for (int f = 0; f < self->figures; ++f) {
        const figure_t *figure = &self->figure[f];
        (void)fprintf(file, "\n%-46s %8s %8s", figure->title, "claimed", "theory");
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
    int count[2][2] = {{0, 0}, {0, 0}};
    int claims = 0;
    for (int k = 0; k < self->rows; ++k) {
        char verdict[48];
        const row_t *row = &self->row[k];
        table_verdict(self, row, verdict, sizeof verdict);
        claims += row->claim != CLAIM_NONE ? 1 : 0;
        count[is_contradicted(self, row) ? 1 : 0][strstr(verdict, "improved") != NULL ? 1 : 0] +=
            row->claim != CLAIM_NONE ? 1 : 0;
    }
    (void)fprintf(
        file,
        "\n%d claims: %d reproduced (%d of them improved), %d contradicted (%d improved). "
        "%u runs, %.0f s of drive\n",
        claims, count[0][0] + count[0][1], count[0][1], count[1][0] + count[1][1], count[1][1],
        self->runs, self->simulated_s);
}

// ---- Files --------------------------------------------------------------------------------------

static const char *const claim_names[] = {"none", "about", "size", "at most", "exactly", "formula"};

static void add_row(cJSON *array, const table_t *self, const row_t *row) {
    char verdict[48];
    cJSON *item = config_json_item(array);
    table_verdict(self, row, verdict, sizeof verdict);
    (void)cJSON_AddStringToObject(item, "id", row->id);
    (void)cJSON_AddStringToObject(item, "figure", row->figure);
    (void)cJSON_AddStringToObject(item, "what", row->what);
    (void)cJSON_AddStringToObject(item, "unit", row->unit);
    (void)cJSON_AddStringToObject(item, "claim", claim_names[row->claim]);
    config_json_number(item, "claimed", row->claimed);
    config_json_number(item, "theory", row->theory);
    (void)cJSON_AddStringToObject(item, "formula", row->formula != NULL ? row->formula : "");
    for (int k = 0; k < self->paper->columns; ++k) {
        if (isnan(row->value[k]) && row->missing[k][0] != '-') {
            (void)cJSON_AddStringToObject(item, self->paper->key[k], row->missing[k]);
        } else {
            config_json_number(item, self->paper->key[k], row->value[k]);
        }
    }
    (void)cJSON_AddStringToObject(item, "verdict", verdict);
    (void)cJSON_AddStringToObject(item, "why", is_contradicted(self, row) ? row->why : "");
}

void reproduce_report_json(FILE *file, const table_t *self, const rig_config_t *config) {
    cJSON *root = config_json_root();
    (void)cJSON_AddStringToObject(root, "paper", self->paper->reference);
    (void)cJSON_AddStringToObject(root, "method", self->paper->introduction);
    config_json_number(root, "window_s", self->paper->window_s);
    config_json_number(root, "runs", self->runs);
    config_json_number(root, "simulated_s", self->simulated_s);
    cJSON *rows = cJSON_AddArrayToObject(root, "rows");
    for (int k = 0; k < self->rows; ++k) {
        add_row(rows, self, &self->row[k]);
    }
    cJSON *notes = cJSON_AddObjectToObject(root, "derivations");
    for (int k = 0; k < self->figures; ++k) {
        const figure_t *figure = &self->figure[k];
        (void)cJSON_AddStringToObject(notes, figure->figure, figure->note);
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
    (void)fputs("id,figure,what,unit,claim,claimed,theory", file);
    for (int k = 0; k < self->paper->columns; ++k) {
        (void)fprintf(file, ",%s", self->paper->key[k]);
    }
    (void)fputs(",verdict\n", file);
    for (int k = 0; k < self->rows; ++k) {
        const row_t *row = &self->row[k];
        char verdict[48];
        table_verdict(self, row, verdict, sizeof verdict);
        (void)fprintf(file, "%s,%s,\"%s\",%s,%s", row->id, row->figure, row->what, row->unit,
                      claim_names[row->claim]);
        csv_number(file, row->claimed, "");
        csv_number(file, row->theory, "");
        for (int c = 0; c < self->paper->columns; ++c) {
            csv_number(file, row->value[c], row->missing[c][0] != '-' ? row->missing[c] : "");
        }
        (void)fprintf(file, ",\"%s\"\n", verdict);
    }
}
