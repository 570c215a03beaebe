#include "rig/commission.h"

#include <math.h>
#include <string.h>

#include "config/refusal.h"
#include "config/schema.h"
#include "config/speed_limits.h"
#include "rig/rig.h"

/// Longer than all time-outs of the commissioning together.
#define LONGEST_s 60.0
/// Of rated speed: the upper speed of the run.
#define RUN_SHARE 0.7

/// Rise of 1/L per ampere, from an inductance without current and one at `i_A`.
static double fall_1_A(double none_H, double at_H, double i_A) {
    return (none_H / at_H - 1.0) / i_A;
}

/// Inductances as the drive defines them: d differential, up to the holding current; q flux over current, up to
/// i_max.
static void note_falls(commission_run_t *self, const rig_config_t *config) {
    const double hold_A = (double)commission_of(self)->current_A;
    const double i_max_A = (double)config->drive.inverter.i_max_A;
    plant_iron_t iron;
    if (!plant_iron_saturates(&self->plant)) {
        return;
    }
    plant_iron_init(&iron, &self->plant);
    const double Ld_H = plant_iron_at(&iron, hold_A, 0.0).Ldd_H;
    const double Lq_H = plant_iron_at(&iron, 0.0, i_max_A).psi_q_Wb / i_max_A;
    self->truth[LODE_COMMISSION_LD_FALL_1_A] = fall_1_A(self->plant.Ld_H, Ld_H, hold_A);
    self->truth[LODE_COMMISSION_LQ_FALL_1_A] = fall_1_A(self->plant.Lq_H, Lq_H, i_max_A);
}

static void note_truth(commission_run_t *self, const rig_config_t *config) {
    const plant_config_t *plant = &self->plant;
    for (int x = 0; x < self->sets * PLANT_PHASES; ++x) {
        self->truth[LODE_COMMISSION_OFFSET_A + x] = (double)config->drive.sense.i_offset_count +
                                                    plant->i_offset_A[x] / plant->i_A_per_count;
    }
    const bool real = plant->level == PLANT_SWITCHING;
    self->truth[LODE_COMMISSION_SIGNALS] = self->sets * PLANT_PHASES;
    self->truth[LODE_COMMISSION_RS_Ohm] = plant->Rs_Ohm + (real ? plant->r_on_Ohm : 0.0);
    self->truth[LODE_COMMISSION_DEAD_V] =
        real ? plant->v_bus_V * plant->dead_time_s / plant->period_s +
                   0.5 * (plant->v_transistor_V + plant->v_diode_V)
             : 0.0;
    self->truth[LODE_COMMISSION_LD_H] = plant->Ld_H;
    self->truth[LODE_COMMISSION_LQ_H] = plant->Lq_H;
    self->truth[LODE_COMMISSION_LXY_H] = plant->Lxy_H;
    self->truth[LODE_COMMISSION_PSI_Wb] = plant->psi_Wb;
    self->truth[LODE_COMMISSION_J_kgm2] = plant->J_kgm2 + plant->load_J_kgm2;
    self->truth[LODE_COMMISSION_B_Nms] = plant->B_Nms;
}

const lode_commission_t *commission_of(const commission_run_t *self) {
    return &self->commission.machine;
}

/// The run goes up to some 0.7 of rated speed with 0.6 of the torque of i_max. If that is more than the voltage
/// allows with the current of rated torque, the rated speed for the run is lower: the run then goes up to the speed of that torque.
static double lowered_rated(const rig_config_t *config) {
    const double rated = (double)config->drive.motor.omega_rated_rad_s;
    if (rig_config_judge(config) != LODE_OK) {
        return NAN; // it will be refused
    }
    const speed_limits_t limits = speed_limits_of(&config->drive);
    const bool reached = RUN_SHARE * rated <= limits.rated_torque_rad_s ||
                         !isnan(limits.weakened_rad_s) || !(limits.rated_torque_rad_s > 0.0);
    return reached ? NAN : limits.rated_torque_rad_s / RUN_SHARE;
}

static lode_status_t init(commission_run_t *self, const rig_config_t *config) {
    lode_drive6_config_t six = rig_config_six(config);
    lode_motor_t *motor = &six.drive.motor;
    self->lowered_rad_s = lowered_rated(config);
    motor->omega_rated_rad_s =
        isnan(self->lowered_rad_s) ? motor->omega_rated_rad_s : (float)self->lowered_rad_s;
    if (self->sets == 1) {
        return lode_commission_init(&self->commission.machine, &self->three, self->three_tuning,
                                    &six.drive);
    }
    return lode_commission6_init(&self->commission, &self->six, self->six_tuning, &six);
}

/// False after a message: the library refuses the configuration.
static bool begin(commission_run_t *self, const rig_config_t *config) {
    *self = (commission_run_t){.sets = rig_config_is_six(config) ? PLANT_SETS : 1};
    const lode_status_t status = init(self, config);
    if (status != LODE_OK) {
        refusal_report(config, status);
    }
    return status == LODE_OK;
}

/// The library is asked before the plant, because its refusal names the keys of the motor.
bool commission_run(commission_run_t *self, const rig_config_t *config) {
    plant_config_t truth;
    double unused_Nm;
    return begin(self, config) && rig_config_plant(config, &truth, &unused_Nm) &&
           commission_run_on(self, config, &truth);
}

static lode_drive6_out_t step(commission_run_t *self, const plant_counts_t sampled[PLANT_SETS]) {
    const lode_counts_t first = rig_counts(&sampled[0]);
    if (self->sets == 1) {
        return (lode_drive6_out_t){{lode_commission_step(&self->commission.machine, &first)}};
    }
    const lode_counts6_t counts = {{first, rig_counts(&sampled[1])}};
    return lode_commission6_step(&self->commission, &counts);
}

static lode_commission_result_t work(commission_run_t *self) {
    return self->sets == 1 ? lode_commission_work(&self->commission.machine)
                           : lode_commission6_work(&self->commission);
}

bool commission_run_on(commission_run_t *self, const rig_config_t *config,
                       const plant_config_t *truth) {
    plant_t plant;
    if (!begin(self, config)) {
        return false;
    }
    self->plant = *truth;
    (void)plant_init(&plant, &self->plant); // rig_config_plant() has checked it
    note_truth(self, config);
    note_falls(self, config);
    lode_commission_result_t result = LODE_COMMISSION_RUNNING;
    while (result == LODE_COMMISSION_RUNNING && self->took_s < LONGEST_s) {
        plant_counts_t sampled[PLANT_SETS];
        plant_truth_t now;
        plant_sample(&plant, sampled, &now);
        const lode_drive6_out_t out = step(self, sampled);
        for (int set = 0; set < self->sets; ++set) {
            rig_write_set(&plant, set, &out.set[set]);
        }
        plant_advance(&plant);
        self->i_max_A = fmax(self->i_max_A, hypot(now.id_A, now.iq_A));
        self->took_s = now.t_s;
        result = work(self);
    }
    return true;
}

/// All quantities but those that may stay unsure and those that this machine does not have.
static bool is_taken_over(const commission_run_t *self, const char *key) {
    static const lode_commission_quantity_t may_be_unsure[] = {
        LODE_COMMISSION_B_Nms, LODE_COMMISSION_LQ_FALL_1_A, LODE_COMMISSION_LXY_H};
    const lode_commission_t *own = commission_of(self);
    for (size_t k = 0; k < sizeof may_be_unsure / sizeof may_be_unsure[0]; ++k) {
        if (strcmp(key, lode_commission_name(may_be_unsure[k])) == 0 &&
            own->found[may_be_unsure[k]].confidence < LODE_COMMISSION_SURE) {
            return false;
        }
    }
    return true;
}

void commission_found(rig_config_t *found, const commission_run_t *self,
                      const rig_config_t *config) {
    static const struct {
        const char *section, *key;
    } measured[] = {
        {"motor", "Rs_Ohm"},      {"motor", "Ld_H"},         {"motor", "Lq_H"},
        {"motor", "psi_Wb"},      {"motor", "J_kgm2"},       {"motor", "B_Nms"},
        {"drive", "dead_time_s"}, {"references", "Lq_fall"}, {"motor", "Lxy_H"},
    };
    *found = *config;
    found->drive = *lode_commission_config(commission_of(self));
    found->drive.motor.omega_rated_rad_s = config->given.motor.omega_rated_rad_s;
    found->given = found->drive;
    if (self->sets == PLANT_SETS) {
        found->given_six.Lxy_H = lode_commission6_config(&self->commission)->Lxy_H;
        found->six = found->given_six;
    }
    for (size_t k = 0; k < sizeof measured / sizeof measured[0]; ++k) {
        if (!is_taken_over(self, measured[k].key)) {
            continue; // it keeps its previous value
        }
        const int row = rig_schema_find(rig_schema(), measured[k].section, measured[k].key);
        found->origin[row] = (rig_origin_t){.file = -1, .line = -1, .measured = true};
    }
}
