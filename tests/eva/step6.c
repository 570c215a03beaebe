// The six-phase step for abstract interpretation: as step.c, of two winding sets, with any counts of either.
#include "lodestar/drive6.h"

#include "any.h"

static lode_drive6_t drive;
static lode_drive6_tuning_t tuning;

// Paper 2's motor, as designed.
static lode_drive6_config_t plain(void) {
    return (lode_drive6_config_t){.drive = {.f_pwm_Hz = 10000.0f,
                                            .motor = {.pole_pairs = 5.0f,
                                                      .Rs_Ohm = 0.8f,
                                                      .Ld_H = 6.4e-3f,
                                                      .Lq_H = 17.4e-3f,
                                                      .psi_Wb = 0.1746f,
                                                      .J_kgm2 = 0.01f},
                                            .inverter = {.v_bus_V = 300.0f, .i_max_A = 15.0f},
                                            .sense = {.i_gain_A_count = 0.0125f,
                                                      .i_offset_count = 2048.0f,
                                                      .v_bus_gain_V_count = 0.1f},
                                            .guard = {.i_trip_A = 25.0f}},
                                  .Lxy_H = 0.9e-3f,
                                  .open_phase = LODE_OPEN_PHASE_GO_ON};
}

int main(void) {
    const lode_drive6_config_t config = plain();
    const lode_status_t status = lode_drive6_tune(&tuning, &config);
    //@ assert tuned: status == LODE_OK;
    // What is tuned is finite: tests/fuzz/fuzz_config.c.
    const lode_status_t begun = lode_drive6_begin(&drive, &tuning);
    //@ admit begun: begun == LODE_OK;
    while (any_bool()) {
        if (any_bool()) {
            const lode_command_t command = any_command();
            (void)lode_drive_post_command(&drive.drive, &command);
        }
        if (any_bool()) {
            (void)lode_drive6_post_tuning(&drive, &tuning);
        }
        if (any_bool()) {
            lode_drive_limit_torque(&drive.drive, any_float());
        }
        const lode_counts6_t counts = {.set = {any_counts(), any_counts()}};
        const lode_drive6_out_t out = lode_drive6_step(&drive, &counts);
        //@ assert duty_1a: 0.0f <= out.set[0].duty.a <= 1.0f;
        //@ assert duty_1b: 0.0f <= out.set[0].duty.b <= 1.0f;
        //@ assert duty_1c: 0.0f <= out.set[0].duty.c <= 1.0f;
        //@ assert duty_2a: 0.0f <= out.set[1].duty.a <= 1.0f;
        //@ assert duty_2b: 0.0f <= out.set[1].duty.b <= 1.0f;
        //@ assert duty_2c: 0.0f <= out.set[1].duty.c <= 1.0f;
    }
    return 0;
}
