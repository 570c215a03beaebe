/// Reads the recordings that the replay tests share with the tool: columns by name.
#ifndef SUPPORT_RECORDING_H
#define SUPPORT_RECORDING_H

#include <stdlib.h>

#include "support/check.h"

#define RECORDING_ROWS 20000

typedef struct {
    int rows;
    double t[RECORDING_ROWS], u_alpha[RECORDING_ROWS], u_beta[RECORDING_ROWS];
    double i_alpha[RECORDING_ROWS], i_beta[RECORDING_ROWS];
    double theta[RECORDING_ROWS], omega[RECORDING_ROWS];
} recording_t;

static inline double *recording_column(recording_t *self, const char *name, size_t length) {
    static const char *const names[] = {"t_s",      "u_alpha_V",   "u_beta_V",     "i_alpha_A",
                                        "i_beta_A", "theta_e_rad", "omega_e_rad_s"};
    double *const columns[] = {self->t,      self->u_alpha, self->u_beta, self->i_alpha,
                               self->i_beta, self->theta,   self->omega};
    for (int i = 0; i < COUNT_OF(names); i++) {
        if (strlen(names[i]) == length && strncmp(name, names[i], length) == 0) {
            return columns[i];
        }
    }
    return NULL;
}

/// Loads RECORDINGS_DIR/name. False if it is not there or not whole.
static inline bool recording_load(recording_t *self, const char *name) {
    char line[512];
    (void)snprintf(line, sizeof line, "%s/%s", RECORDINGS_DIR, name);
    FILE *file = fopen(line, "r");
    double *columns[16];
    int count = 0;
    self->rows = 0;
    if (file == NULL || fgets(line, sizeof line, file) == NULL) {
        return false;
    }
    for (char *field = line; *field != '\0' && count < COUNT_OF(columns);) {
        const size_t length = strcspn(field, ",\r\n");
        columns[count++] = recording_column(self, field, length);
        field += length;
        field += strspn(field, ",\r\n");
    }
    bool whole = count >= 7;
    while (whole && self->rows < RECORDING_ROWS && fgets(line, sizeof line, file) != NULL) {
        char *at = line;
        for (int c = 0; c < count && whole; c++) {
            char *end;
            const double x = strtod(at, &end);
            whole = end != at && isfinite(x);
            if (columns[c] != NULL) {
                columns[c][self->rows] = x;
            }
            at = *end == ',' ? end + 1 : end;
        }
        self->rows++;
    }
    (void)fclose(file);
    return whole && self->rows > 100;
}

#endif
