// From converter counts to a sample.
#ifndef LODE_SENSE_INLINE_H
#define LODE_SENSE_INLINE_H

#include "lodestar/sense.h"

#ifdef LODE_WITHOUT_SHUNT_WINDOW

LODE_INLINE bool lode_sense_is_windowed(const lode_sense_tuning_t *tuning) {
    (void)tuning;
    return false;
}

LODE_INLINE uint_least8_t lode_sense_omitted(const lode_sense_tuning_t *tuning, lode_abc_t duty) {
    (void)tuning;
    (void)duty;
    return LODE_PHASES;
}

LODE_INLINE uint_least8_t lode_sense_next_omitted(const lode_sense_tuning_t *tuning,
                                                  lode_abc_t duty) {
    return lode_sense_omitted(tuning, duty);
}

#else

// Not every phase is sampled in every period.
LODE_INLINE bool lode_sense_is_windowed(const lode_sense_tuning_t *tuning) {
    return tuning->windowed;
}

// The phase that cannot be sampled while the duties are `duty`; LODE_PHASES: all can.
uint_least8_t lode_sense_omitted(const lode_sense_tuning_t *tuning, lode_abc_t duty);

// The same where a phase may be missing, which is rarely one: 30 cycles less than the call.
LODE_INLINE uint_least8_t lode_sense_next_omitted(const lode_sense_tuning_t *tuning,
                                                  lode_abc_t duty) {
    const float most = tuning->duty_max;
    const bool all = !tuning->two_shunts && duty.a <= most && duty.b <= most && duty.c <= most;
    return LODE_USUALLY(all) ? (uint_least8_t)LODE_PHASES : lode_sense_omitted(tuning, duty);
}

#endif

// A current in use sits at the end of the converter's range.
bool lode_sense_is_railed(const lode_sense_t *self, const lode_sense_tuning_t *tuning,
                          const lode_sample_t *sample);

// Phase currents from their offsets, 1/256 count.
typedef struct {
    int32_t a;
    int32_t b;
    int32_t c;
} lode_sense_currents_t;

// With one phase taken from the other two, whose sum it balances.
LODE_INLINE lode_sense_currents_t lode_sense_complete(lode_sense_currents_t i,
                                                      uint_least8_t omitted) {
    const lode_sense_currents_t from_others = {-i.b - i.c, -i.a - i.c, -i.a - i.b};
    i.a = omitted == 0u ? from_others.a : i.a;
    i.b = omitted == 1u ? from_others.b : i.b;
    i.c = omitted == 2u ? from_others.c : i.c;
    return i;
}

// A magnitude is beyond `limit`.
LODE_INLINE bool lode_sense_exceeds(lode_sense_currents_t i, uint32_t limit) {
    return LODE_RARELY((uint32_t)i.a + limit > 2u * limit) ||
           LODE_RARELY((uint32_t)i.b + limit > 2u * limit) ||
           LODE_RARELY((uint32_t)i.c + limit > 2u * limit);
}

// Of `counts`, without the phase `omitted`.
LODE_INLINE lode_sense_currents_t lode_sense_currents(const lode_sense_t *self,
                                                      const lode_counts_t *counts,
                                                      uint_least8_t omitted) {
    const lode_sense_currents_t i = {LODE_COUNT_FRACTION * (int32_t)counts->i[0] - self->offset[0],
                                     LODE_COUNT_FRACTION * (int32_t)counts->i[1] - self->offset[1],
                                     LODE_COUNT_FRACTION * (int32_t)counts->i[2] - self->offset[2]};
#ifdef LODE_WITHOUT_SHUNT_WINDOW
    (void)omitted;
    return i;
#else
    return LODE_RARELY(omitted != LODE_PHASES) ? lode_sense_complete(i, omitted) : i;
#endif
}

// `omitted`: lode_sense_omitted() of the duties that acted when the sample was taken. The voltage is
// not known here.
LODE_INLINE lode_sample_t lode_sense_step(const lode_sense_t *self,
                                          const lode_sense_tuning_t *tuning,
                                          const lode_counts_t *counts, uint_least8_t omitted) {
    const lode_sense_currents_t i = lode_sense_currents(self, counts, omitted);
    return (lode_sample_t){
        .i_A = {(float)(2 * i.a - i.b - i.c) * tuning->alpha_gain,
                (float)(i.b - i.c) * tuning->beta_gain},
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

// The same, but current, voltage and bus are left as they are: for what rarely looks at a sample once more,
// rather than have it kept at hand in all periods.
void lode_sense_again(const lode_sense_t *self, const lode_counts_t *counts, uint_least8_t omitted,
                      lode_sample_t *sample);

LODE_INLINE float lode_sense_temperature_degC(const lode_sense_tuning_t *tuning, uint16_t count) {
    return tuning->temperature_offset + (float)count * tuning->temperature_gain;
}

#endif
