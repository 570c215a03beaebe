#include "plant/adc.h"

#include "plant/turn.h"

#include <math.h>

void plant_noise_init(plant_noise_t *self, uint64_t seed) {
    *self = (plant_noise_t){.left = 0};
    for (int n = 0; n < 4; n++) {
        // splitmix64: spreads any seed, zero included, over the whole state
        seed += UINT64_C(0x9E3779B97F4A7C15);
        uint64_t z = seed;
        z = (z ^ (z >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
        z = (z ^ (z >> 27)) * UINT64_C(0x94D049BB133111EB);
        self->state[n] = z ^ (z >> 31);
    }
}

static uint64_t rotate_left(uint64_t x, int k) {
    return (x << k) | (x >> (64 - k));
}

static uint64_t next_bits(uint64_t s[4]) {
    const uint64_t result = rotate_left(s[0] + s[3], 23) + s[0];
    const uint64_t t = s[1] << 17;
    s[2] ^= s[0];
    s[3] ^= s[1];
    s[1] ^= s[2];
    s[0] ^= s[3];
    s[2] ^= t;
    s[3] = rotate_left(s[3], 45);
    return result;
}

/// In (0, 1], valid for the logarithm.
static double uniform(plant_noise_t *self) {
    return ((double)(next_bits(self->state) >> 11) + 1.0) * (1.0 / 9007199254740992.0);
}

static void fill_store(plant_noise_t *self) {
    for (int n = 0; n < PLANT_NOISE_STORE; n += 2) {
        const double radius = sqrt(-2.0 * log(uniform(self)));
        double c, s;
        plant_turn(uniform(self), &c, &s);
        self->store[n] = radius * c;
        self->store[n + 1] = radius * s;
    }
    self->left = PLANT_NOISE_STORE;
}

double plant_noise_next(plant_noise_t *self) {
    if (self->left == 0) {
        fill_store(self);
    }
    return self->store[PLANT_NOISE_STORE - self->left--];
}

void plant_adc_init(plant_adc_t *self, const plant_config_t *config) {
    *self = (plant_adc_t){
        .full_scale_count = (double)((1L << config->adc_bits) - 1L),
        .middle_count = (double)(1L << (config->adc_bits - 1)),
        .i_count_per_A = 1.0 / config->i_A_per_count,
        .v_count_per_V = 1.0 / config->v_bus_V_per_count,
        .temperature_count_per_degC = 1.0 / config->temperature_degC_per_count,
        .i_noise_A = config->i_noise_A,
        .v_noise_V = config->v_bus_noise_V,
        .temperature_noise_degC = config->temperature_noise_degC,
        .temperature_zero_degC = config->temperature_zero_degC,
        .sets = config->sets == PLANT_SETS ? PLANT_SETS : 1,
    };
    for (int n = 0; n < PLANT_LEGS; n++) {
        self->i_offset_A[n] = config->i_offset_A[n];
        self->i_gain[n] = 1.0 + config->i_gain_error[n];
    }
    plant_noise_init(&self->noise, config->seed);
}

static uint16_t to_count(const plant_adc_t *self, double value) {
    const double up = value + 0.5; // the conversion truncates
    return (uint16_t)(up >= 1.0 ? (up < self->full_scale_count ? up : self->full_scale_count)
                                : 0.0);
}

/// No random number is drawn without noise, so that an ideal ADC costs nothing.
static double noise(plant_adc_t *self, double rms) {
    return rms > 0.0 ? rms * plant_noise_next(&self->noise) : 0.0;
}

uint16_t plant_adc_link(plant_adc_t *self, double i_A) {
    const double seen_A =
        i_A * self->i_gain[0] + self->i_offset_A[0] + noise(self, self->i_noise_A);
    return to_count(self, self->middle_count + seen_A * self->i_count_per_A);
}

void plant_adc_convert(plant_adc_t *self, const double i_A[PLANT_LEGS], double v_bus_V,
                       double temperature_degC, plant_counts_t *counts) {
    for (int n = 0; n < self->sets * PLANT_PHASES; n++) {
        const double seen_A =
            i_A[n] * self->i_gain[n] + self->i_offset_A[n] + noise(self, self->i_noise_A);
        counts[n / PLANT_PHASES].i[n % PLANT_PHASES] =
            to_count(self, self->middle_count + seen_A * self->i_count_per_A);
    }
    const double v_V = v_bus_V + noise(self, self->v_noise_V);
    counts->v_bus = to_count(self, v_V * self->v_count_per_V);
    const double seen_degC = temperature_degC + noise(self, self->temperature_noise_degC);
    counts->temperature = to_count(self, (seen_degC - self->temperature_zero_degC) *
                                             self->temperature_count_per_degC);
    for (int set = 1; set < self->sets; set++) {
        counts[set].v_bus = counts->v_bus;
        counts[set].temperature = counts->temperature;
    }
}
