/// The verdict on a claim over all choices that its paper leaves open (docs/papers.md).
#ifndef RIG_REPRODUCE_VERDICT_H
#define RIG_REPRODUCE_VERDICT_H

#include "reproduce/table.h"

typedef enum {
    VERDICT_NONE,           ///< no claim
    VERDICT_REPRODUCED,     ///< in every variant with every seed
    VERDICT_CONTRADICTED,   ///< in none
    VERDICT_DEPENDS,        ///< on a choice that the paper leaves open, or on the noise
    VERDICT_NOT_COMPARABLE, ///< a datum is missing
    VERDICT_IDENTITY,       ///< restates a table by arithmetic: not counted
    VERDICTS
} verdict_t;

typedef struct {
    verdict_t verdict;
    int held, of;       ///< samples
    bool decides[AXES]; ///< VERDICT_DEPENDS: the smallest set of axes that decides where it holds
    bool noise;         ///< in some variants it holds only with some of the seeds
} judgement_t;

const char *verdict_name(verdict_t verdict);

judgement_t verdict_of(const table_t *table, const row_t *row);

/// True if the claim holds with this value; false for NaN.
bool verdict_holds(const row_t *row, double value);

/// Least and largest of a variant's samples. False: all are missing.
bool verdict_range(const row_t *row, int variant, double *low, double *high);

/// Explains the verdict from the samples: where the claim holds and where not, the nearest value, or the
/// missing datum. Empty for a reproduced claim.
void verdict_reason(const table_t *table, const row_t *row, char *text, size_t size);

#endif
