#include "lodestar/commission6.h"

#ifndef LODE_WITHOUT_COMMISSIONING

#include "commission_machine.h"
#include "inverter_inline.h"

#include <stddef.h>

lode_status_t lode_commission6_init(lode_commission6_t *self, lode_drive6_t *drive,
                                    lode_drive6_tuning_t tuning[2],
                                    const lode_drive6_config_t *config) {
    if (self == NULL || drive == NULL || tuning == NULL || config == NULL) {
        return LODE_ERROR_NULL;
    }
    lode_drive6_config_t given = *config;
    given.drive.motor.sets = (float)LODE_SETS;
    lode_drive6_config_t designed = given;
    designed.drive = lode_commission_blind(&given.drive);
    lode_drive6_design(&designed);
    const lode_status_t status = lode_drive6_init(drive, &tuning[0], &designed);
    if (status == LODE_OK) {
        lode_commission_begin(&self->machine, &drive->drive, &given.drive, &designed.drive);
        lode_commission_push_by(&self->machine, tuning[0].xy.pi.kp,
                                tuning[0].xy.circle * config->drive.inverter.v_bus_V);
        self->drive = drive;
        self->tuning = tuning;
        self->config = given;
    }
    return status;
}

lode_drive6_out_t lode_commission6_step(lode_commission6_t *self, const lode_counts6_t *counts) {
    lode_drive6_t *drive = self->drive;
    const lode_inverter_t *inverter = &drive->drive.inverter;
    const uint32_t now = drive->drive.steps;
    const lode_sets_t u_V = {
        {lode_inverter_realised(inverter, now),
         lode_ab_scale(inverter->v_bus_V, drive->inverter_2.written[now % 2u])}};
    const lode_drive6_out_t out = lode_drive6_step(drive, counts);
    const lode_commission_period_t period = {
        {&counts->set[0], &counts->set[1]}, lode_vsd_ab(u_V), lode_vsd_xy(u_V), drive->i_xy_A};
    lode_commission_follow(&self->machine, &period);
    drive->xy.x.integral += self->machine.push_V;
    return out;
}

lode_commission_result_t lode_commission6_work(lode_commission6_t *self) {
    lode_commission_t *machine = &self->machine;
    if (machine->wants_tuning) {
        lode_commission_take_standstill(machine);
        self->config.Lxy_H = machine->found[LODE_COMMISSION_LXY_H].value;
        lode_drive6_config_t designed = self->config;
        designed.drive = machine->config;
        lode_drive6_design(&designed);
        machine->designed = designed.drive;
        lode_drive6_config_t config = self->config;
        config.drive = lode_commission_for_run(machine);
        lode_drive6_tuning_t *next = &self->tuning[self->drive->tuning == &self->tuning[0] ? 1 : 0];
        const lode_status_t status = lode_drive6_tune(next, &config);
        if (status == LODE_OK) {
            (void)lode_drive6_post_tuning(self->drive, next);
        }
        lode_commission_go_on(machine, status);
    }
    const lode_commission_result_t result = machine->result; // written last by the interrupt
    if (result != LODE_COMMISSION_RUNNING) {
        LODE_SIGNAL_FENCE();
        self->config.drive = machine->config;
    }
    return result;
}

const lode_drive6_config_t *lode_commission6_config(const lode_commission6_t *self) {
    return &self->config;
}

#endif
