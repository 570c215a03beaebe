/// What becomes of a claim over all that its paper leaves open (docs/papers.md).
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
    bool decides[AXES]; ///< VERDICT_DEPENDS: the fewest axes that tell where it holds
    bool noise;         ///< and there are variants in which it holds with some of the seeds only
} judgement_t;

const char *verdict_name(verdict_t verdict);

judgement_t verdict_of(const table_t *table, const row_t *row);

/// True where the claim holds with this value; never of NaN.
bool verdict_holds(const row_t *row, double value);

/// Least and largest of a variant's samples. False: all are missing.
bool verdict_range(const row_t *row, int variant, double *low, double *high);

/// In words, from the samples: where the claim holds and where not, or what comes nearest to it, or what
/// is missing. Empty for what is reproduced.
void verdict_reason(const table_t *table, const row_t *row, char *text, size_t size);

#endif
