#include "rig/commission.h"

#include <math.h>
#include <string.h>

#include "config/refusal.h"
#include "config/schema.h"
#include "rig/rig.h"

/// Longer than all of its own time-outs together.
#define LONGEST_s 60.0

static void note_truth(commission_run_t *self, const rig_config_t *config) {
    const plant_config_t *plant = &self->plant;
    for (int x = 0; x < PLANT_PHASES; ++x) {
        self->truth[LODE_COMMISSION_OFFSET_A + x] = (double)config->drive.sense.i_offset_count +
                                                    plant->i_offset_A[x] / plant->i_A_per_count;
    }
    const bool real = plant->level == PLANT_SWITCHING;
    self->truth[LODE_COMMISSION_SIGNALS] = PLANT_PHASES;
    self->truth[LODE_COMMISSION_RS_Ohm] = plant->Rs_Ohm + (real ? plant->r_on_Ohm : 0.0);
    self->truth[LODE_COMMISSION_DEAD_V] =
        real ? plant->v_bus_V * plant->dead_time_s / plant->period_s +
                   0.5 * (plant->v_transistor_V + plant->v_diode_V)
             : 0.0;
    self->truth[LODE_COMMISSION_LD_H] = plant->Ld_H;
    self->truth[LODE_COMMISSION_LQ_H] = plant->Lq_H;
    self->truth[LODE_COMMISSION_PSI_Wb] = plant->psi_Wb;
    self->truth[LODE_COMMISSION_J_kgm2] = plant->J_kgm2 + plant->load_J_kgm2;
    self->truth[LODE_COMMISSION_B_Nms] = plant->B_Nms;
}

bool commission_run(commission_run_t *self, const rig_config_t *config) {
    plant_config_t truth;
    double unused_Nm;
    return rig_config_plant(config, &truth, &unused_Nm) && commission_run_on(self, config, &truth);
}

bool commission_run_on(commission_run_t *self, const rig_config_t *config,
                       const plant_config_t *truth) {
    plant_t plant;
    *self = (commission_run_t){.plant = *truth};
    (void)plant_init(&plant, &self->plant); // rig_config_plant() has tried
    note_truth(self, config);
    const lode_status_t status = lode_commission_init(&self->commission, &config->given);
    if (status != LODE_OK) {
        refusal_report(config, status);
        return false;
    }
    lode_commission_result_t result = LODE_COMMISSION_RUNNING;
    while (result == LODE_COMMISSION_RUNNING && self->took_s < LONGEST_s) {
        plant_counts_t sampled;
        plant_truth_t now;
        plant_sample(&plant, &sampled, &now);
        const lode_counts_t counts = rig_counts(&sampled);
        const lode_drive_out_t out = lode_commission_step(&self->commission, &counts);
        const double duty[PLANT_PHASES] = {(double)out.duty.a, (double)out.duty.b,
                                           (double)out.duty.c};
        plant_write(&plant, duty, (plant_gates_t)out.gates); // the same three
        plant_advance(&plant);
        self->i_max_A = fmax(self->i_max_A, hypot(now.id_A, now.iq_A));
        self->took_s = now.t_s;
        result = lode_commission_work(&self->commission);
    }
    return true;
}

void commission_found(rig_config_t *found, const commission_run_t *self,
                      const rig_config_t *config) {
    static const struct {
        const char *section, *key;
    } measured[] = {
        {"motor", "Rs_Ohm"}, {"motor", "Ld_H"},  {"motor", "Lq_H"},        {"motor", "psi_Wb"},
        {"motor", "J_kgm2"}, {"motor", "B_Nms"}, {"drive", "dead_time_s"},
    };
    const lode_commission_value_t *friction = &self->commission.found[LODE_COMMISSION_B_Nms];
    *found = *config;
    found->drive = *lode_commission_config(&self->commission);
    found->given = found->drive;
    for (size_t k = 0; k < sizeof measured / sizeof measured[0]; ++k) {
        if (strcmp(measured[k].key, "B_Nms") == 0 && friction->confidence < LODE_COMMISSION_SURE) {
            continue; // it stays as it was known
        }
        const int row = rig_schema_find(rig_schema(), measured[k].section, measured[k].key);
        found->origin[row] = (rig_origin_t){.file = -1, .line = -1, .measured = true};
    }
}
