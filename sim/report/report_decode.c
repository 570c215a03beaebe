#include "report/report_decode.h"

#include <math.h>
#include <string.h>

#include "config/config_json.h"
#include "support/channels.h"
#include "support/stats.h"

static const char *const kind_names[] = {"frames", "ring", "scope"};
static const char *const kind_texts[] = {"frames of a telemetry ring", "buffer of a telemetry ring",
                                         "buffer of a scope"};
static const char *const state_names[] = {"idle", "armed", "triggered", "done"};
static const char *const trigger_names[] = {"immediate", "rising", "falling", "fault"};

// Values of a named channel that are listed: there are 7 modes, and few checks trip in one record.
enum { VALUES_MAX = 12 };

static double period_s(const decode_t *decoded) {
    return (double)decoded->decimation / decoded->f_pwm_Hz;
}

static void channel_stats(const decode_t *decoded, uint32_t channel, rig_stats_t *stats) {
    rig_stats_reset(stats);
    for (size_t k = 0; k < decoded->rows; ++k) {
        rig_stats_add(stats, (double)decoded->value[k * decoded->channels + channel]);
    }
}

/// A value as a name if it has one.
static void print_value(FILE *file, uint32_t channel, float value) {
    const char *name = channels_value_name(channel, (double)value);
    if (name != NULL) {
        (void)fputs(name, file);
    } else {
        (void)fprintf(file, "%.9g", (double)value);
    }
}

/// The values of a channel in the order of time, as many as fit.
static int values_of(const decode_t *decoded, uint32_t channel, float list[VALUES_MAX]) {
    int count = 0;
    for (size_t row = 0; row < decoded->rows && count < VALUES_MAX; ++row) {
        const float *value = &decoded->value[row * decoded->channels + channel];
        int known = 0;
        while (known < count && lode_channel_bits(list[known]) != lode_channel_bits(*value)) {
            ++known;
        }
        if (known == count) {
            list[count++] = *value;
        }
    }
    return count;
}

// ---- Table --------------------------------------------------------------------------------------

static void print_trigger(FILE *file, const decode_t *decoded) {
    (void)fprintf(file, "state %s, trigger %s", state_names[decoded->state],
                  trigger_names[decoded->trigger]);
    if (decoded->trigger == (uint32_t)LODE_TRIGGER_RISING ||
        decoded->trigger == (uint32_t)LODE_TRIGGER_FALLING) {
        (void)fprintf(file, " of %s through %.6g %s", channels_name(decoded->source),
                      (double)decoded->level, channels_unit(decoded->source));
    }
    if (decoded->has_event) {
        (void)fprintf(file, ": event at %.9g s, %zu rows before it\n", decoded->t_s[decoded->event],
                      decoded->event);
    } else {
        (void)fputs(": not yet triggered\n", file);
    }
    (void)fputs(decoded->checked ? "checked: its CRC-32 is right\n"
                                 : "not checked: a dump carries no CRC-32\n",
                file);
}

static void print_gaps(FILE *file, const decode_t *decoded) {
    (void)fprintf(file,
                  "missing: %llu frames in %zu places by their numbers; %lu left out by the "
                  "drive (overruns)\n",
                  (unsigned long long)decoded->lost, decoded->gaps,
                  (unsigned long)decoded->overruns);
    for (size_t k = 0; k < decoded->gaps && k < DECODE_PLACES_MAX; ++k) {
        const decode_gap_t *gap = &decoded->gap[k];
        (void)fprintf(file, "  offset %zu: %lu missing", gap->offset, (unsigned long)gap->lost);
        if (gap->row > 0) {
            (void)fprintf(file, " after %.6g s", decoded->t_s[gap->row - 1]);
        }
        (void)fputc('\n', file);
    }
    if (decoded->gaps > DECODE_PLACES_MAX) {
        (void)fprintf(file, "  ... and %zu more places\n", decoded->gaps - DECODE_PLACES_MAX);
    }
}

static void print_damage(FILE *file, const decode_t *decoded) {
    if (decoded->damaged > 0) {
        (void)fprintf(file, "DAMAGED: %zu places hold octets that are no frame\n",
                      decoded->damaged);
    }
    for (size_t k = 0; k < decoded->damaged && k < DECODE_PLACES_MAX; ++k) {
        (void)fprintf(file, "  offset %zu: %zu octets\n", decoded->damage[k].offset,
                      decoded->damage[k].octets);
    }
    if (decoded->damaged > DECODE_PLACES_MAX) {
        (void)fprintf(file, "  ... and %zu more places\n", decoded->damaged - DECODE_PLACES_MAX);
    }
    if (decoded->before > 0) {
        (void)fprintf(file, "skipped: %zu octets at the beginning\n", decoded->before);
    }
    if (decoded->after > 0) {
        (void)fprintf(file, "cut off: %zu octets at the end\n", decoded->after);
    }
    if (decoded->undescribed > 0) {
        (void)fprintf(file, "skipped: %zu frames before the first description\n",
                      decoded->undescribed);
    }
    if (decoded->restarts > 0) {
        (void)fprintf(file, "the drive was restarted %zu times; t_s restarts with it\n",
                      decoded->restarts);
    }
}

static void print_names(FILE *file, const decode_t *decoded, uint32_t channel) {
    float value[VALUES_MAX];
    const uint32_t number = decoded->channel[channel];
    const int count = values_of(decoded, channel, value);
    (void)fprintf(file, "%-17s %-8s ", channels_name(number), "name");
    for (int k = 0; k < count; ++k) {
        (void)fputs(k > 0 ? ", " : "", file);
        print_value(file, number, value[k]);
    }
    (void)fputs(count == VALUES_MAX ? ", ...; last " : "; last ", file);
    print_value(file, number, decoded->value[(decoded->rows - 1) * decoded->channels + channel]);
    (void)fputc('\n', file);
}

static void print_figures(FILE *file, const decode_t *decoded, uint32_t channel) {
    rig_stats_t stats;
    const uint32_t number = decoded->channel[channel];
    channel_stats(decoded, channel, &stats);
    (void)fprintf(file, "%-17s %-8s %12.6g %12.6g %12.6g %12.6g\n", channels_name(number),
                  channels_unit(number), rig_stats_min(&stats), rig_stats_mean(&stats),
                  rig_stats_max(&stats),
                  (double)decoded->value[(decoded->rows - 1) * decoded->channels + channel]);
}

void report_decode_table(FILE *file, const char *path, const decode_t *decoded) {
    (void)fprintf(file, "%s: %s, %s\n", path, kind_texts[decoded->kind],
                  decode_order_name(decoded->order));
    (void)fprintf(
        file, "%zu rows of %lu channels, one every %.6g ms (%.6g Hz / %lu), %.9g .. %.9g s\n",
        decoded->rows, (unsigned long)decoded->channels, 1e3 * period_s(decoded), decoded->f_pwm_Hz,
        (unsigned long)decoded->decimation, decoded->t_s[0], decoded->t_s[decoded->rows - 1]);
    if (decoded->kind == DECODE_SCOPE) {
        print_trigger(file, decoded);
    } else {
        print_gaps(file, decoded);
    }
    print_damage(file, decoded);
    (void)fputs(
        "\nchannel           unit              min         mean          max         last\n", file);
    for (uint32_t k = 0; k < decoded->channels; ++k) {
        if (channels_is_named(decoded->channel[k])) {
            print_names(file, decoded, k);
        } else {
            print_figures(file, decoded, k);
        }
    }
}

// ---- CSV ----------------------------------------------------------------------------------------

void report_decode_csv(FILE *file, const decode_t *decoded) {
    const bool scope = decoded->kind == DECODE_SCOPE;
    (void)fputs(scope ? "period,t_s,t_event_s" : "frame,t_s", file);
    for (uint32_t k = 0; k < decoded->channels; ++k) {
        (void)fprintf(file, ",%s", channels_name(decoded->channel[k]));
    }
    (void)fputc('\n', file);
    for (size_t row = 0; row < decoded->rows; ++row) {
        (void)fprintf(file, "%lu,%.12g", (unsigned long)decoded->number[row], decoded->t_s[row]);
        if (scope && decoded->has_event) {
            (void)fprintf(file, ",%.9g",
                          ((double)row - (double)decoded->event) * period_s(decoded));
        } else if (scope) {
            (void)fputs(",", file);
        }
        for (uint32_t k = 0; k < decoded->channels; ++k) {
            (void)fputc(',', file);
            print_value(file, decoded->channel[k], decoded->value[row * decoded->channels + k]);
        }
        (void)fputc('\n', file);
    }
}

// ---- JSON ---------------------------------------------------------------------------------------

/// The names that a channel has had, in the order of time; a number if a value has no name.
static void add_names(cJSON *item, const decode_t *decoded, uint32_t channel) {
    cJSON *array = cJSON_AddArrayToObject(item, "values");
    float value[VALUES_MAX];
    const int count = values_of(decoded, channel, value);
    for (int k = 0; k < count; ++k) {
        const char *name = channels_value_name(decoded->channel[channel], (double)value[k]);
        (void)cJSON_AddItemToArray(array, name != NULL ? cJSON_CreateString(name)
                                                       : cJSON_CreateNumber((double)value[k]));
    }
}

static void add_channels(cJSON *root, const decode_t *decoded) {
    cJSON *array = cJSON_AddArrayToObject(root, "channels");
    for (uint32_t k = 0; k < decoded->channels; ++k) {
        cJSON *item = cJSON_CreateObject();
        rig_stats_t stats;
        channel_stats(decoded, k, &stats);
        (void)cJSON_AddItemToArray(array, item);
        (void)cJSON_AddStringToObject(item, "name", channels_name(decoded->channel[k]));
        (void)cJSON_AddStringToObject(item, "unit", channels_unit(decoded->channel[k]));
        config_json_number(item, "number", (double)decoded->channel[k]);
        config_json_number(item, "min", rig_stats_min(&stats));
        config_json_number(item, "mean", rig_stats_mean(&stats));
        config_json_number(item, "max", rig_stats_max(&stats));
        if (channels_is_named(decoded->channel[k])) {
            add_names(item, decoded, k);
        }
    }
}

static void add_frames(cJSON *root, const decode_t *decoded) {
    config_json_number(root, "overruns", (double)decoded->overruns);
    config_json_number(root, "missing", (double)decoded->lost);
    config_json_number(root, "missing_places", (double)decoded->gaps);
    config_json_number(root, "damaged_places", (double)decoded->damaged);
    config_json_number(root, "undescribed", (double)decoded->undescribed);
    config_json_number(root, "restarts", (double)decoded->restarts);
    cJSON *gaps = cJSON_AddArrayToObject(root, "gaps");
    for (size_t k = 0; k < decoded->gaps && k < DECODE_PLACES_MAX; ++k) {
        cJSON *item = config_json_item(gaps);
        config_json_number(item, "offset", (double)decoded->gap[k].offset);
        config_json_number(item, "missing", (double)decoded->gap[k].lost);
    }
    cJSON *damage = cJSON_AddArrayToObject(root, "damage");
    for (size_t k = 0; k < decoded->damaged && k < DECODE_PLACES_MAX; ++k) {
        cJSON *item = config_json_item(damage);
        config_json_number(item, "offset", (double)decoded->damage[k].offset);
        config_json_number(item, "octets", (double)decoded->damage[k].octets);
    }
}

static void add_scope(cJSON *root, const decode_t *decoded) {
    (void)cJSON_AddStringToObject(root, "state", state_names[decoded->state]);
    (void)cJSON_AddStringToObject(root, "trigger", trigger_names[decoded->trigger]);
    (void)cJSON_AddStringToObject(root, "trigger_channel", channels_name(decoded->source));
    config_json_number(root, "trigger_level", (double)decoded->level);
    config_json_number(root, "event_row", decoded->has_event ? (double)decoded->event : NAN);
    config_json_number(root, "event_s", decoded->has_event ? decoded->t_s[decoded->event] : NAN);
    (void)cJSON_AddBoolToObject(root, "checked", decoded->checked);
}

void report_decode_json(FILE *file, const char *path, const decode_t *decoded) {
    cJSON *root = config_json_root();
    (void)cJSON_AddStringToObject(root, "file", path);
    (void)cJSON_AddStringToObject(root, "kind", kind_names[decoded->kind]);
    (void)cJSON_AddStringToObject(root, "order", decode_order_name(decoded->order));
    config_json_number(root, "rows", (double)decoded->rows);
    config_json_number(root, "f_pwm_Hz", decoded->f_pwm_Hz);
    config_json_number(root, "decimation", (double)decoded->decimation);
    config_json_number(root, "row_s", period_s(decoded));
    config_json_number(root, "octets_before", (double)decoded->before);
    config_json_number(root, "octets_after", (double)decoded->after);
    if (decoded->kind == DECODE_SCOPE) {
        add_scope(root, decoded);
    } else {
        add_frames(root, decoded);
    }
    add_channels(root, decoded);
    (void)config_json_write(file, root);
}
