#include "decode/parsed.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/// Which octet of four is the lowest, the next one, ...
static const struct {
    int at[4];
    const char *name;
} orders[] = {
    {{0, 1, 2, 3}, "little endian"},
    {{3, 2, 1, 0}, "big endian"},
    {{1, 0, 3, 2}, "16-bit units, low one first, each with its high octet first"},
    {{2, 3, 0, 1}, "16-bit units, high one first, each with its low octet first"},
};
typedef char all_orders[sizeof orders / sizeof orders[0] == DECODE_ORDERS ? 1 : -1];

const char *decode_order_name(int order) {
    return orders[order].name;
}

uint32_t decode_word(const decode_source_t *source, size_t offset) {
    const unsigned char *octet = source->data + offset;
    uint32_t word = 0u;
    for (int k = 0; k < 4; ++k) {
        word |= (uint32_t)octet[orders[source->order].at[k]] << (8 * k);
    }
    return word;
}

float decode_float(uint32_t bits) {
    float value = 0.0F;
    memcpy(&value, &bits, sizeof value);
    return value;
}

bool decode_refuse(decode_t *self, size_t offset, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    self->offset = offset;
    (void)vsnprintf(self->message, sizeof self->message, format, arguments);
    va_end(arguments);
    return false;
}

bool decode_setup(decode_t *self, const decode_source_t *source, size_t f_pwm_at,
                  size_t decimation_at, size_t channels_at) {
    self->f_pwm_Hz = (double)decode_float(decode_word(source, f_pwm_at));
    self->decimation = decode_word(source, decimation_at);
    if (!(self->f_pwm_Hz >= 1.0e3 && self->f_pwm_Hz <= 2.0e5)) {
        return decode_refuse(self, f_pwm_at, "a PWM rate of %g Hz; expected 1e3 .. 2e5",
                             self->f_pwm_Hz);
    }
    if (self->decimation < 1u || self->decimation > UINT16_MAX) {
        return decode_refuse(self, decimation_at, "a decimation of %lu; expected 1 .. 65535",
                             (unsigned long)self->decimation);
    }
    for (uint32_t k = 0; k < self->channels; ++k) {
        const size_t at = channels_at + 4 * (size_t)k;
        self->channel[k] = decode_word(source, at);
        if (self->channel[k] > UINT8_MAX) {
            return decode_refuse(self, at, "channel number %lu; expected 0 .. 255",
                                 (unsigned long)self->channel[k]);
        }
    }
    return true;
}

void decode_add_row(decode_t *self, const decode_source_t *source, size_t offset, uint32_t number,
                    double t_s) {
    self->t_s[self->rows] = t_s;
    self->number[self->rows] = number;
    for (uint32_t k = 0; k < self->channels; ++k) {
        self->value[self->rows * self->channels + k] =
            decode_float(decode_word(source, offset + 4 * (size_t)k));
    }
    self->rows++;
}

void decode_note_gap(decode_t *self, size_t offset, uint32_t lost) {
    if (self->gaps < DECODE_PLACES_MAX) {
        self->gap[self->gaps] = (decode_gap_t){offset, self->rows, lost};
    }
    self->gaps++;
    self->lost += lost;
}

void decode_free(decode_t *self) {
    free(self->t_s);
    free(self->number);
    free(self->value);
    self->t_s = NULL;
    self->number = NULL;
    self->value = NULL;
}
