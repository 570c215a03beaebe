#include "rig/capture.h"

#include <stdlib.h>
#include <string.h>

#include "support/channels.h"
#include "support/diag.h"
#include "support/outputs.h"

// Rows before the event.
#define PRE_SHARE 0.5F

bool capture_wanted(const options_t *options) {
    return options->ring != NULL || options->scope != NULL;
}

static bool take_channels(const char *list, lode_channels_config_t *config) {
    char text[512];
    const char *wanted = list != NULL ? list
                                      : "mode,id_A,iq_A,id_ref_A,iq_ref_A,ud_V,uq_V,v_bus_V,"
                                        "theta_rad,omega_rad_s,lock";
    (void)snprintf(text, sizeof text, "%s", wanted);
    for (char *name = strtok(text, ","); name != NULL; name = strtok(NULL, ",")) {
        const lode_channel_t channel = channels_find(name);
        if (channel == LODE_CHANNEL_COUNT || config->count == LODE_CHANNELS_MAX) {
            rig_error("--channels: '%s'; expected at most %d of %s", name, LODE_CHANNELS_MAX,
                      channels_list());
            return false;
        }
        config->channel[config->count++] = channel;
    }
    if (config->count == 0) {
        rig_error("--channels: expected some of %s", channels_list());
    }
    return config->count > 0;
}

static bool take_every(const char *text, lode_channels_config_t *config) {
    char *end = NULL;
    const unsigned long every = text != NULL ? strtoul(text, &end, 10) : 1;
    if (text != NULL &&
        (text[0] < '0' || text[0] > '9' || *end != '\0' || every < 1 || every > UINT16_MAX)) {
        rig_error("--every %s: expected a whole number, 1 .. 65535", text);
        return false;
    }
    config->decimation = (uint16_t)every;
    return true;
}

static bool take_trigger(const char *text, lode_scope_config_t *config) {
    config->trigger = LODE_TRIGGER_FAULT;
    if (text == NULL || strcmp(text, "fault") == 0) {
        return true;
    }
    if (strcmp(text, "immediate") == 0) {
        config->trigger = LODE_TRIGGER_IMMEDIATE;
        return true;
    }
    char name[64];
    const size_t length = strcspn(text, "<>");
    (void)snprintf(name, sizeof name, "%.*s", (int)length, text);
    char *end = NULL;
    config->trigger = text[length] == '<' ? LODE_TRIGGER_FALLING : LODE_TRIGGER_RISING;
    config->source = channels_find(name);
    config->level = text[length] != '\0' ? strtof(text + length + 1, &end) : 0.0F;
    if (config->source == LODE_CHANNEL_COUNT || end == NULL || end == text + length + 1 ||
        *end != '\0' || !lode_is_finite(config->level)) {
        rig_error("--trigger %s: expected fault, immediate, or a channel and a level as in "
                  "'omega_rad_s>300'; channels: %s",
                  text, channels_list());
        return false;
    }
    return true;
}

bool capture_start(capture_t *self, const options_t *options, float f_pwm_Hz) {
    lode_scope_config_t config = {.rows = {.f_pwm_Hz = f_pwm_Hz}, .pre_share = PRE_SHARE};
    self->ring_file = NULL;
    self->scope_file = NULL;
    if (!take_channels(options->channels, &config.rows) ||
        !take_every(options->every, &config.rows) || !take_trigger(options->trigger, &config)) {
        return false;
    }
    lode_status_t status = lode_ring_init(&self->ring, &config.rows, self->ring_buffer,
                                          sizeof self->ring_buffer / sizeof self->ring_buffer[0]);
    if (status == LODE_OK) {
        status = lode_scope_init(&self->scope, &config, self->scope_buffer, CAPTURE_SCOPE_WORDS);
    }
    if (status != LODE_OK) {
        rig_error("the library refused the recorders: %s", lode_status_name(status));
        return false;
    }
    lode_scope_arm(&self->scope);
    return outputs_open(&self->ring_file, options->ring) &&
           outputs_open(&self->scope_file, options->scope);
}

static void write_octets(FILE *file, const uint16_t *octets, uint32_t count) {
    for (uint32_t k = 0; k < count; ++k) {
        (void)fputc(octets[k], file);
    }
}

static void drain_ring(capture_t *self) {
    uint16_t octets[256];
    uint32_t count = 0;
    do {
        count = lode_ring_drain(&self->ring, octets, 256);
        write_octets(self->ring_file, octets, count);
    } while (count > 0);
}

void capture_step(capture_t *self, const lode_drive_t *drive) {
    if (self->ring_file != NULL) {
        lode_ring_step(&self->ring, drive);
        drain_ring(self);
    }
    if (self->scope_file != NULL) {
        lode_scope_step(&self->scope, drive);
    }
}

static void dump_scope(const capture_t *self) {
    for (uint32_t k = 0; k < CAPTURE_SCOPE_WORDS; ++k) {
        lode_wire_t wire = {0};
        lode_wire_load(&wire, self->scope_buffer[k]);
        while (wire.left > 0) {
            (void)fputc(lode_wire_octet(&wire), self->scope_file);
        }
    }
}

void capture_finish(capture_t *self) {
    if (self->scope_file == NULL) {
        return;
    }
    if (lode_scope_state(&self->scope) != LODE_SCOPE_DONE) {
        dump_scope(self);
        return;
    }
    uint16_t octets[256];
    uint32_t count = 0;
    do {
        count = lode_scope_drain(&self->scope, octets, 256);
        write_octets(self->scope_file, octets, count);
    } while (count > 0);
}
