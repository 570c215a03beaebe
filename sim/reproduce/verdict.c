#include "reproduce/verdict.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { SUBSETS = 1 << AXES };

const char *verdict_name(verdict_t verdict) {
    static const char *const names[VERDICTS] = {"",        "reproduced",     "contradicted",
                                                "depends", "not comparable", "identity"};
    return names[verdict];
}

bool verdict_holds(const row_t *row, double value) {
    const double size = fabs(row->claimed);
    const double about = fmax(1.5, 0.3 * size);
    switch (row->claim) {
    case CLAIM_ABOUT:
        return fabs(value - row->claimed) <= about;
    case CLAIM_SIZE:
        return fabs(fabs(value) - size) <= about;
    case CLAIM_AT_MOST:
        return fabs(value) <= size + row->reading;
    case CLAIM_AT_LEAST:
        return value >= row->claimed - row->reading;
    case CLAIM_EXACTLY:
    case CLAIM_FORMULA:
        return fabs(value - row->claimed) <= fmax(0.01, 0.02 * size);
    case CLAIM_NONE:
    default:
        return false;
    }
}

bool verdict_range(const row_t *row, int variant, double *low, double *high) {
    *low = HUGE_VAL;
    *high = -HUGE_VAL;
    for (int s = 0; s < row->seeds; ++s) { // fmin and fmax drop a NaN
        *low = fmin(*low, row->sample[variant][s]);
        *high = fmax(*high, row->sample[variant][s]);
    }
    return *low <= *high;
}

static int held_in(const row_t *row, int variant) {
    int held = 0;
    for (int s = 0; s < row->seeds; ++s) {
        held += verdict_holds(row, row->sample[variant][s]) ? 1 : 0;
    }
    return held;
}

/// True if two variants agree in all axes of `subset`.
static bool alike(const paper_t *paper, int subset, int a, int b) {
    int of_a[AXES];
    int of_b[AXES];
    (void)table_choices(paper, a, of_a);
    (void)table_choices(paper, b, of_b);
    for (int k = 0; k < AXES; ++k) {
        if ((subset >> k & 1) != 0 && of_a[k] != of_b[k]) {
            return false;
        }
    }
    return true;
}

/// The claim holds with all, none or some of the seeds: 1, 0, 2.
static int state_of(const row_t *row, int variant) {
    const int held = held_in(row, variant);
    return held == 0 ? 0 : (held == row->seeds ? 1 : 2);
}

/// True if the axes of `subset` alone decide where the claim holds.
static bool explains(const table_t *table, const row_t *row, int subset) {
    const int variants = table_variants(table->paper);
    for (int a = 0; a < variants; ++a) {
        for (int b = 0; b < a; ++b) {
            if (row->ran[a] && row->ran[b] && alike(table->paper, subset, a, b) &&
                state_of(row, a) != state_of(row, b)) {
                return false;
            }
        }
    }
    return true;
}

static int axes_in(int subset) {
    int axes = 0;
    for (int k = 0; k < AXES; ++k) {
        axes += subset >> k & 1;
    }
    return axes;
}

static int fewest(const table_t *table, const row_t *row) {
    int best = SUBSETS - 1;
    for (int subset = 0; subset < SUBSETS; ++subset) {
        if (axes_in(subset) < axes_in(best) && explains(table, row, subset)) {
            best = subset;
        }
    }
    return best;
}

judgement_t verdict_of(const table_t *table, const row_t *row) {
    judgement_t out = {.verdict = VERDICT_NONE};
    const int variants = table_variants(table->paper);
    for (int v = 0; v < variants && row->claim != CLAIM_NONE; ++v) {
        if (row->ran[v]) {
            out.of += row->seeds;
            out.held += held_in(row, v);
            out.noise = out.noise || state_of(row, v) == 2;
        }
    }
    if (row->claim == CLAIM_NONE) {
        return out;
    }
    if (row->claim == CLAIM_FORMULA) {
        out.verdict = VERDICT_IDENTITY;
        out.of = 1;
        out.held = verdict_holds(row, row->theory) ? 1 : 0;
    } else if (row->lacks != NULL || out.of == 0) {
        out.verdict = VERDICT_NOT_COMPARABLE;
    } else if (out.held == 0 || out.held == out.of) {
        out.verdict = out.held == 0 ? VERDICT_CONTRADICTED : VERDICT_REPRODUCED;
    } else {
        const int subset = fewest(table, row);
        out.verdict = VERDICT_DEPENDS;
        for (int k = 0; k < AXES; ++k) {
            out.decides[k] = (subset >> k & 1) != 0;
        }
    }
    return out;
}

// ---- In words -----------------------------------------------------------------------------------

typedef struct {
    char *text;
    size_t size, length;
} writer_t;

static void put(writer_t *self, const char *text) {
    const size_t left = self->size - self->length;
    const int length = snprintf(self->text + self->length, left, "%s", text);
    self->length += (size_t)length < left ? (size_t)length : left - 1u;
}

static void put_range(writer_t *self, double low, double high, bool any, bool lost) {
    char text[64];
    const bool one = fabs(high - low) <= 0.005 * fmax(fabs(low), fabs(high));
    if (!any) {
        put(self, "lost");
        return;
    }
    (void)snprintf(text, sizeof text, one ? "%.3g" : "%.3g .. %.3g", low, high);
    put(self, text);
    put(self, lost ? " or lost" : "");
}

/// Samples of all variants that agree with `variant` in the axes of `subset`.
static void put_group(writer_t *self, const table_t *table, const row_t *row, int subset,
                      int variant) {
    int choice[AXES];
    double low = HUGE_VAL, high = -HUGE_VAL;
    bool any = false, lost = false;
    const int variants = table_choices(table->paper, variant, choice);
    const char *before = "";
    for (int k = 0; k < AXES; ++k) {
        if ((subset >> k & 1) != 0) {
            put(self, before);
            put(self, table->paper->axis[k].choice[choice[k]]);
            before = ", ";
        }
    }
    for (int v = 0; v < variants; ++v) {
        double least, most;
        if (row->ran[v] && alike(table->paper, subset, v, variant)) {
            const bool seen = verdict_range(row, v, &least, &most);
            low = fmin(low, least);
            high = fmax(high, most);
            any = any || seen;
            for (int s = 0; s < row->seeds; ++s) {
                lost = lost || isnan(row->sample[v][s]);
            }
        }
    }
    put(self, " (");
    put_range(self, low, high, any, lost);
    put(self, ")");
}

/// True if all variants that agree with `variant` in the axes of `subset` are in `state`.
static bool uniform(const table_t *table, const row_t *row, int subset, int variant, int state) {
    for (int v = 0; v < table_variants(table->paper); ++v) {
        if (row->ran[v] && alike(table->paper, subset, v, variant) && state_of(row, v) != state) {
            return false;
        }
    }
    return true;
}

/// The fewest axes of `subset` that suffice to name variants of this state, `variant` among them.
static int shortest(const table_t *table, const row_t *row, int subset, int variant, int state) {
    int best = subset;
    for (int less = 1; less < subset; ++less) {
        if ((less & ~subset) == 0 && axes_in(less) < axes_in(best) &&
            uniform(table, row, less, variant, state)) {
            best = less;
        }
    }
    return best;
}

/// The groups in which it holds with all (1), none (0) or some (2) of the seeds.
static void put_groups(writer_t *self, const table_t *table, const row_t *row, int subset,
                       int state, const char *heading) {
    const int variants = table_variants(table->paper);
    bool said[VARIANTS_MAX] = {false};
    const char *before = heading; // ends a sentence
    for (int v = 0; v < variants; ++v) {
        if (said[v] || !row->ran[v] || state_of(row, v) != state) {
            continue;
        }
        const int group = shortest(table, row, subset, v, state);
        put(self, before);
        put_group(self, table, row, group, v);
        before = "; ";
        for (int w = v; w < variants; ++w) {
            said[w] = said[w] || alike(table->paper, group, v, w);
        }
    }
}

static void put_depends(writer_t *self, const table_t *table, const row_t *row,
                        const judgement_t *judgement) {
    int subset = 0;
    const char *before = "on ";
    for (int k = 0; k < AXES; ++k) {
        if (judgement->decides[k]) {
            subset |= 1 << k;
            put(self, before);
            put(self, table->paper->axis[k].name);
            before = " and ";
        }
    }
    if (judgement->noise) {
        put(self, before);
        put(self, "noise");
    }
    put_groups(self, table, row, subset, 1, ". Holds: ");
    put_groups(self, table, row, subset, 2, ". With some seeds: ");
    put_groups(self, table, row, subset, 0, ". Not: ");
}

/// Distance of a value from the claim, in the measure of the claim.
static double distance(const row_t *row, double value) {
    if (row->claim == CLAIM_AT_MOST) {
        return fabs(value);
    }
    if (row->claim == CLAIM_AT_LEAST) {
        return row->claimed - value;
    }
    return row->claim == CLAIM_SIZE ? fabs(fabs(value) - fabs(row->claimed))
                                    : fabs(value - row->claimed);
}

/// True if the row was run with more than one choice of an axis.
static bool varies(const table_t *table, const row_t *row, int axis) {
    int first = -1;
    for (int v = 0; v < table_variants(table->paper); ++v) {
        int choice[AXES];
        (void)table_choices(table->paper, v, choice);
        if (row->ran[v] && first >= 0 && choice[axis] != first) {
            return true;
        }
        first = row->ran[v] ? choice[axis] : first;
    }
    return false;
}

static void put_nearest(writer_t *self, const table_t *table, const row_t *row) {
    int nearest = -1;
    double value = NAN;
    for (int v = 0; v < table_variants(table->paper); ++v) {
        for (int s = 0; s < row->seeds && row->ran[v]; ++s) {
            const double now = row->sample[v][s];
            if (!isnan(now) && !(distance(row, now) >= distance(row, value))) {
                nearest = v;
                value = now;
            }
        }
    }
    if (nearest < 0) {
        put(self, "the rotor is lost or stalls in every variant");
        return;
    }
    char text[48];
    int choice[AXES];
    (void)table_choices(table->paper, nearest, choice);
    (void)snprintf(text, sizeof text, "nearest: %.3g with ", value);
    put(self, text);
    const char *before = "";
    for (int k = 0; k < AXES; ++k) {
        if (varies(table, row, k)) {
            put(self, before);
            put(self, table->paper->axis[k].choice[choice[k]]);
            before = ", ";
        }
    }
}

void verdict_reason(const table_t *table, const row_t *row, char *text, size_t size) {
    writer_t writer = {text, size, 0};
    const judgement_t judgement = verdict_of(table, row);
    text[0] = '\0';
    switch (judgement.verdict) {
    case VERDICT_CONTRADICTED:
        put_nearest(&writer, table, row);
        break;
    case VERDICT_DEPENDS:
        put_depends(&writer, table, row, &judgement);
        break;
    case VERDICT_NOT_COMPARABLE:
        put(&writer, "missing: ");
        put(&writer, row->lacks != NULL ? row->lacks : "a form of it that could be run");
        break;
    case VERDICT_IDENTITY:
        put(&writer, judgement.held == 1 ? "" : "its own formula gives another value");
        break;
    case VERDICT_NONE:
    case VERDICT_REPRODUCED:
    case VERDICTS:
    default:
        break;
    }
    if (row->because[0] != '\0' && text[0] != '\0') {
        put(&writer, ". ");
        put(&writer, row->because);
    }
}
