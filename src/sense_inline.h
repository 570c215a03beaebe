// From ADC counts to a sample.
#ifndef LODE_SENSE_INLINE_H
#define LODE_SENSE_INLINE_H

#include "lodestar/sense.h"

#ifdef LODE_WITHOUT_SHUNT_WINDOW
LODE_INLINE uint_least8_t lode_sense_omitted(const lode_sense_tuning_t *tuning, lode_abc_t duty) {
    (void)tuning;
    (void)duty;
    return LODE_PHASES;
}
#else
// The phase that cannot be sampled while `duty` acts; LODE_PHASES: all can be.
uint_least8_t lode_sense_omitted(const lode_sense_tuning_t *tuning, lode_abc_t duty);
#endif

// Phases omitted in the next two samples (a period's duties act in the following one): two bits each, the next sample's in the
// lower ones.
#define OMITTED_BITS 2u
#define OMITTED_MASK 3u
#define OMITTED_NONE ((uint32_t)LODE_PHASES | (uint32_t)LODE_PHASES << OMITTED_BITS)

// `phase` is omitted in both samples.
LODE_INLINE uint_least8_t lode_sense_omit_both(uint_least8_t phase) {
    return (uint_least8_t)(phase | (uint32_t)phase << OMITTED_BITS);
}

// `phase` is omitted while the newest duties act: in the sample at the end of their period, and in the one at its beginning
// unless that is without another phase already, whose low side has just been on for too short a time.
LODE_INLINE uint_least8_t lode_sense_omit_later(uint_least8_t omitted, uint_least8_t phase) {
    const uint32_t next = (uint32_t)omitted & OMITTED_MASK;
    const uint32_t first = next == (uint32_t)LODE_PHASES ? phase : next;
    return (uint_least8_t)(first | (uint32_t)phase << OMITTED_BITS);
}

// A sampled current is at an end of the ADC's range.
bool lode_sense_is_railed(const lode_sense_t *self, const lode_sense_tuning_t *tuning,
                          const lode_sample_t *sample);

// Phase currents relative to their offsets, 1/256 count.
typedef struct {
    int32_t a;
    int32_t b;
    int32_t c;
} lode_sense_currents_t;

// Computes the omitted phase, 0 .. 2, from the other two.
LODE_INLINE lode_sense_currents_t lode_sense_complete(lode_sense_currents_t i,
                                                      uint_least8_t omitted) {
    if (omitted == 0u) {
        i.a = -(i.b + i.c);
    } else if (omitted == 1u) {
        i.b = -(i.c + i.a);
    } else {
        i.c = -(i.a + i.b);
    }
    return i;
}

// The magnitude of a current exceeds `limit`.
LODE_INLINE bool lode_sense_exceeds(lode_sense_currents_t i, uint32_t limit) {
    // the hint saves 8 cycles of board_enhanced
    return LODE_RARELY((uint32_t)i.a + limit > 2u * limit || (uint32_t)i.b + limit > 2u * limit ||
                       (uint32_t)i.c + limit > 2u * limit);
}

LODE_INLINE lode_sense_currents_t lode_sense_currents(const lode_sense_t *self,
                                                      const lode_counts_t *counts) {
    return (lode_sense_currents_t){
        LODE_COUNT_FRACTION * (int32_t)counts->i[0] - self->offset[0],
        LODE_COUNT_FRACTION * (int32_t)counts->i[1] - self->offset[1],
        LODE_COUNT_FRACTION * (int32_t)counts->i[2] - self->offset[2],
    };
}

// The voltage is filled in later.
LODE_INLINE lode_sample_t lode_sense_sample(const lode_sense_tuning_t *tuning,
                                            const lode_counts_t *counts, lode_sense_currents_t i,
                                            uint_least8_t omitted) {
    const int32_t alpha = 2 * i.a - i.b - i.c;
    const int32_t beta = i.b - i.c;
    return (lode_sample_t){
        .i_A = {(float)alpha * tuning->alpha_gain, (float)beta * tuning->beta_gain},
        .u_V = {0.0f, 0.0f},
        .v_bus_V = (float)counts->v_bus * tuning->v_bus_gain,
        .i = {i.a, i.b, i.c},
        .stamp = counts->stamp,
        .temperature = counts->temperature,
        .omitted = omitted,
        .trip = counts->trip,
        .alert = lode_sense_exceeds(i, tuning->alert),
    };
}

// Replaces the phase `omitted`.
LODE_INLINE lode_sense_currents_t lode_sense_without(lode_sense_currents_t i,
                                                     uint_least8_t omitted) {
#ifdef LODE_WITHOUT_SHUNT_WINDOW
    (void)omitted;
    return i;
#else
    return omitted != (uint_least8_t)LODE_PHASES ? lode_sense_complete(i, omitted) : i;
#endif
}

// `omitted`: lode_sense_omitted() of the duties that acted when the sample was taken.
LODE_INLINE lode_sample_t lode_sense_step(const lode_sense_t *self,
                                          const lode_sense_tuning_t *tuning,
                                          const lode_counts_t *counts, uint_least8_t omitted) {
    const lode_sense_currents_t i = lode_sense_currents(self, counts);
    return lode_sense_sample(tuning, counts, lode_sense_without(i, omitted), omitted);
}

// The same for consecutive periods: takes the present sample's omitted phase out of `omitted`.
LODE_INLINE lode_sample_t lode_sense_next(const lode_sense_t *self,
                                          const lode_sense_tuning_t *tuning,
                                          const lode_counts_t *counts, uint_least8_t *omitted) {
    lode_sense_currents_t i = lode_sense_currents(self, counts);
    uint_least8_t now = LODE_PHASES;
#ifdef LODE_WITHOUT_SHUNT_WINDOW
    (void)omitted;
#else
    if (LODE_RARELY(*omitted != OMITTED_NONE)) { // the hint saves 11 cycles of board_enhanced
        now = (uint_least8_t)(*omitted & OMITTED_MASK);
        i = lode_sense_complete(i, now);
        if (tuning->two_shunts == 0u) {
            *omitted =
                lode_sense_omit_later((uint_least8_t)(*omitted >> OMITTED_BITS), LODE_PHASES);
        }
    }
#endif
    return lode_sense_sample(tuning, counts, i, now);
}

// As lode_sense_step(), but leaves current vector, voltage and bus as they are. For rare checks: they compute the sample again,
// so that it need not be kept in every period.
void lode_sense_again(const lode_sense_t *self, const lode_counts_t *counts, uint_least8_t omitted,
                      lode_sample_t *sample);

// Count of the hotter of two power stages.
LODE_INLINE uint16_t lode_sense_hotter(const lode_sense_tuning_t *tuning, uint16_t a, uint16_t b) {
    return (a > b) == (tuning->temperature_gain > 0.0f) ? a : b;
}

LODE_INLINE float lode_sense_temperature_degC(const lode_sense_tuning_t *tuning, uint16_t count) {
    return tuning->temperature_offset + (float)count * tuning->temperature_gain;
}

#endif
