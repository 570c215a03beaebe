/// ADC channels with their errors, and their noise generator.
#ifndef PLANT_ADC_H
#define PLANT_ADC_H

#include "plant/config.h"

/// Random numbers made in advance, so that one transform does not wait for another.
enum { PLANT_NOISE_STORE = 16 };

/// xoshiro256++ (Blackman and Vigna, 2019) feeding the Box-Muller transform.
typedef struct {
    uint64_t state[4];
    double store[PLANT_NOISE_STORE];
    int left; ///< unused numbers at the end of the store
} plant_noise_t;

typedef struct {
    plant_noise_t noise;
    double full_scale_count, middle_count;
    double i_count_per_A, v_count_per_V, temperature_count_per_degC;
    double i_offset_A[PLANT_LEGS], i_gain[PLANT_LEGS];
    int sets;
    double i_noise_A, v_noise_V, temperature_noise_degC, temperature_zero_degC;
} plant_adc_t;

void plant_adc_init(plant_adc_t *self, const plant_config_t *config);

/// Fills the currents, voltage and temperature of `counts`, one per set; leaves the rest unchanged.
void plant_adc_convert(plant_adc_t *self, const double i_A[PLANT_LEGS], double v_bus_V,
                       double temperature_degC, plant_counts_t *counts);

/// One sample of a shunt in the DC link, with noise, offset and gain error of phase a's ADC channel.
uint16_t plant_adc_link(plant_adc_t *self, double i_A);

void plant_noise_init(plant_noise_t *self, uint64_t seed);

/// Normally distributed, mean 0, variance 1.
double plant_noise_next(plant_noise_t *self);

#endif
