#include "rig/runlog.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/diag.h"

#define COLUMN(name, digits)                                                                       \
    { #name, offsetof(runlog_row_t, name), digits, 1, false }
#define COLUMN_OF_SIX(name, digits)                                                                \
    { #name, offsetof(runlog_row_t, name), digits, 2, false }
#define COLUMN_BY_WAVE(name, digits)                                                               \
    { #name, offsetof(runlog_row_t, name), digits, 1, true }

#define COLUMN_OF_ADAPTATION(name, digits)                                                         \
    { #name, offsetof(runlog_row_t, name), digits, RUNLOG_ADAPTED, false }

#define COLUMN_OF_DERATING(name, digits)                                                           \
    { #name, offsetof(runlog_row_t, name), digits, RUNLOG_DERATED, false }

const runlog_column_t runlog_columns[] = {
    COLUMN(t_s, 12),
    COLUMN(phase, 3),
    COLUMN(mode, 3),
    COLUMN(speed_command_rpm, 7),
    COLUMN(speed_ref_rpm, 7),
    COLUMN(speed_rpm, 7),
    COLUMN(speed_est_rpm, 7),
    COLUMN(theta_e_rad, 7),
    COLUMN(theta_est_rad, 7),
    COLUMN(angle_error_deg, 6),
    COLUMN(id_A, 6),
    COLUMN(iq_A, 6),
    COLUMN(i1_A, 6),
    COLUMN(i2_A, 6),
    COLUMN(i1_ref_A, 6),
    COLUMN(i2_ref_A, 6),
    COLUMN(u1_V, 6),
    COLUMN(u2_V, 6),
    COLUMN(i_alpha_A, 9), // enough digits to restore a float exactly
    COLUMN(i_beta_A, 9),
    COLUMN(u_alpha_V, 9),
    COLUMN(u_beta_V, 9),
    COLUMN(e_alpha_V, 6),
    COLUMN(e_beta_V, 6),
    COLUMN(e_true_alpha_V, 6),
    COLUMN(e_true_beta_V, 6),
    COLUMN(ia_A, 6),
    COLUMN(ib_A, 6),
    COLUMN(ic_A, 6),
    COLUMN(duty_a, 6),
    COLUMN(duty_b, 6),
    COLUMN(duty_c, 6),
    COLUMN(v_bus_V, 6),
    COLUMN(lock, 5),
    COLUMN(torque_Nm, 6),
    COLUMN(load_Nm, 6),
    COLUMN(load_est_Nm, 6),
    COLUMN_OF_SIX(ia2_A, 6),
    COLUMN_OF_SIX(ib2_A, 6),
    COLUMN_OF_SIX(ic2_A, 6),
    COLUMN_OF_SIX(ix_A, 6),
    COLUMN_OF_SIX(iy_A, 6),
    COLUMN_OF_SIX(e_true_x_V, 6),
    COLUMN_OF_SIX(e_true_y_V, 6),
    COLUMN_OF_SIX(duty_a2, 6),
    COLUMN_OF_SIX(duty_b2, 6),
    COLUMN_OF_SIX(duty_c2, 6),
    COLUMN_OF_SIX(open_phase, 6),
    COLUMN_OF_SIX(found_open, 6),
    COLUMN_BY_WAVE(w_h, 4),
    COLUMN_BY_WAVE(er_h_deg, 5),
    COLUMN_BY_WAVE(er_e_deg, 5),
    COLUMN_BY_WAVE(Lq_H, 6),
    COLUMN_BY_WAVE(Lq_est_H, 6),
    COLUMN_BY_WAVE(psi_est_Wb, 6),
    COLUMN_BY_WAVE(Lq_confidence, 4),
    COLUMN_OF_ADAPTATION(adapted_J_kgm2, 6),
    COLUMN_OF_ADAPTATION(adapted_J_confidence, 4),
    COLUMN_OF_ADAPTATION(adapted_psi_Wb, 6),
    COLUMN_OF_ADAPTATION(adapted_psi_confidence, 4),
    COLUMN_OF_ADAPTATION(adapted_Rs_Ohm, 6),
    COLUMN_OF_ADAPTATION(adapted_Rs_confidence, 4),
    COLUMN_OF_DERATING(winding_heat, 6),
    COLUMN_OF_DERATING(derated_share, 6),
    {NULL, 0, 0, 0, false},
};

void runlog_init(runlog_t *self) {
    memset(self, 0, sizeof *self);
}

void runlog_free(runlog_t *self) {
    free(self->row);
    runlog_init(self);
}

bool runlog_add(runlog_t *self, const runlog_row_t *row) {
    if (self->rows == self->capacity) {
        const size_t capacity = self->capacity > 0 ? 2 * self->capacity : 4096;
        runlog_row_t *more = realloc(self->row, capacity * sizeof *more);
        if (more == NULL) {
            rig_error("out of memory for %zu logged rows; expected a larger log_s", capacity);
            return false;
        }
        self->row = more;
        self->capacity = capacity;
    }
    self->row[self->rows++] = *row;
    return true;
}

void runlog_note(runlog_t *self, double t_s, const char *text) {
    if (self->events == RUNLOG_EVENTS_MAX) {
        self->events_dropped++;
        return;
    }
    runlog_event_t *event = &self->event[self->events++];
    event->t_s = t_s;
    (void)snprintf(event->text, sizeof event->text, "%s", text);
}

bool runlog_has(const runlog_t *self, const runlog_column_t *column) {
    if (column->sets == RUNLOG_ADAPTED) {
        return self->adapts;
    }
    if (column->sets == RUNLOG_DERATED) {
        return self->derates;
    }
    return (column->sets == 1 || self->sets == column->sets) && (!column->by_wave || self->by_wave);
}

double runlog_value(const runlog_row_t *row, const runlog_column_t *column) {
    double value = 0.0;
    memcpy(&value, (const char *)row + column->offset, sizeof value);
    return value;
}
