#include "commands/command_decode.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "decode/decode.h"
#include "report/plot_decode.h"
#include "report/report_decode.h"
#include "support/atomic_file.h"
#include "support/inputs.h"
#include "support/outputs.h"
#include "support/shown.h"

typedef struct {
    FILE *csv;
    FILE *json;
    plot_output_t plot;
} files_t;

static bool want_of(const char *kind, decode_want_t *want) {
    static const char *const names[] = {"auto", "ring", "scope"};
    for (size_t k = 0; k < sizeof names / sizeof names[0]; ++k) {
        if (kind == NULL || strcmp(kind, names[k]) == 0) {
            *want = (decode_want_t)k;
            return true;
        }
    }
    rig_error("--kind %s: expected auto, ring or scope", kind);
    return false;
}

/// The whole file, to be freed by the caller; NULL after a message.
static unsigned char *read_all(const char *path, size_t *size) {
    FILE *file = inputs_open(path);
    unsigned char *data = NULL;
    size_t capacity = 0;
    bool good = file != NULL;
    *size = 0;
    while (good && feof(file) == 0 && ferror(file) == 0) {
        if (*size == capacity) {
            capacity = capacity > 0 ? 2 * capacity : 65536;
            unsigned char *more = realloc(data, capacity);
            good = more != NULL;
            data = good ? more : data;
        }
        *size += good ? fread(data + *size, 1, capacity - *size, file) : 0;
    }
    if (!good || ferror(file) != 0) {
        rig_error_at(path, 0, "%s; expected octets of a ring or a scope", strerror(errno));
        free(data);
        data = NULL;
    }
    if (file != NULL) {
        (void)fclose(file);
    }
    return data;
}

static bool load(decode_t *decoded, const char *path, decode_want_t want) {
    size_t size = 0;
    unsigned char *data = read_all(path, &size);
    if (data == NULL) {
        return false;
    }
    const bool good = decode_parse(decoded, data, size, want);
    if (!good) {
        rig_error_at(path, 0, "offset %zu: %s", decoded->offset, decoded->message);
    }
    free(data);
    return good;
}

static bool open_files(files_t *files, const options_t *options) {
    return outputs_open(&files->csv, options->csv) && outputs_open(&files->json, options->json) &&
           plot_open(&files->plot, options->plot);
}

/// False after a message.
static bool write_files(const files_t *files, const char *path, const decode_t *decoded) {
    if (files->csv != NULL) {
        report_decode_csv(files->csv, decoded);
    }
    if (files->json != NULL) {
        report_decode_json(files->json, path, decoded);
    }
    return files->plot.file == NULL || plot_decode(&files->plot, path, decoded);
}

rig_exit_t command_decode(const options_t *options) {
    decode_t decoded;
    decode_want_t want = DECODE_WANT_ANY;
    files_t files = {.csv = NULL};
    if (!want_of(options->kind, &want) || (options->plot != NULL && !plot_available()) ||
        !load(&decoded, options->recording, want)) {
        return RIG_BAD_INPUT;
    }
    bool good = open_files(&files, options);
    shown_t table = {.file = NULL};
    good = good && shown_begin(&table);
    if (good) {
        report_decode_table(table.file, options->recording, &decoded);
        good = shown_end(&table);
        files.plot.text = table.text;
        good = good && write_files(&files, options->recording, &decoded);
    }
    shown_free(&table);
    const bool damaged = decoded.damaged > 0;
    decode_free(&decoded);
    if (!good || !atomic_file_commit_all()) {
        return RIG_BAD_INPUT;
    }
    outputs_say(options->csv);
    outputs_say(options->json);
    outputs_say(options->plot);
    return damaged ? RIG_FAILED : RIG_DONE;
}
