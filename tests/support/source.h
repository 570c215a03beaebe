/// A drive whose bus voltage and temperature count its periods: every row of a recorder then says which
/// period it is of, and whether it is of one period only.
#ifndef SUPPORT_SOURCE_H
#define SUPPORT_SOURCE_H

#include "support/check.h"

#include "lodestar/channel.h"

#define SOURCE_F_PWM_Hz 5000.0f

typedef struct {
    lode_drive_t drive;
    lode_drive_tuning_t tuning;
    uint32_t periods; ///< done
} source_t;

static inline void source_init(source_t *self) {
    const lode_drive_config_t config = {.f_pwm_Hz = SOURCE_F_PWM_Hz,
                                        .motor = paper_motor(),
                                        .inverter = {.v_bus_V = 200.0f, .i_max_A = 12.0f},
                                        .sense = {.i_gain_A_count = 0.0125f,
                                                  .i_offset_count = 2048.0f,
                                                  .v_bus_gain_V_count = 0.125f,
                                                  .temperature_gain_degC_count = 1.0f}};
    self->periods = 0u;
    TEST_ASSERT_EQUAL_STRING(
        "LODE_OK", lode_status_name(lode_drive_init(&self->drive, &self->tuning, &config)));
}

/// Period n shows n modulo 4096 as temperature, and half of it as an eighth of the bus voltage.
static inline void source_step(source_t *self) {
    const uint16_t n = (uint16_t)(self->periods++ & 4095u);
    const lode_counts_t counts = {
        .i = {2048u, 2048u, 2048u}, .v_bus = (uint16_t)(n / 2u), .temperature = n};
    (void)lode_drive_step(&self->drive, &counts);
}

/// The two channels above, then the mode.
static inline lode_channels_config_t source_channels(uint16_t decimation) {
    return (lode_channels_config_t){
        .f_pwm_Hz = SOURCE_F_PWM_Hz,
        .decimation = decimation,
        .count = 3u,
        .channel = {LODE_CHANNEL_TEMPERATURE, LODE_CHANNEL_V_BUS, LODE_CHANNEL_MODE}};
}

/// `row` holds the three channels of period `n`.
static inline void source_check_row(const uint32_t *row, uint32_t n) {
    TEST_ASSERT_EQUAL_FLOAT((float)(n & 4095u), check_from_bits(row[0]));
    TEST_ASSERT_EQUAL_FLOAT(0.125f * (float)((n & 4095u) / 2u), check_from_bits(row[1]));
    TEST_ASSERT_EQUAL_FLOAT(0.0f, check_from_bits(row[2]));
}

#endif
