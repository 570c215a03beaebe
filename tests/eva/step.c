// The whole step for abstract interpretation: any counts, stamps and trips, any commands in any order, and two tunings
// that take turns. What thread and interrupt share is written between two steps, never in one.
#include "lodestar/drive.h"

#include "any.h"

static lode_drive_t drive;
static lode_drive_tuning_t tunings[2];

// Paper 1's motor, as designed.
static lode_drive_config_t plain(void) {
    return (lode_drive_config_t){
        .f_pwm_Hz = 5000.0f,
        .motor = {.pole_pairs = 3.0f,
                  .Rs_Ohm = 0.35f,
                  .Ld_H = 4.6e-3f,
                  .Lq_H = 7.2e-3f,
                  .psi_Wb = 0.142f,
                  .J_kgm2 = 2.4e-3f},
        .inverter = {.v_bus_V = 200.0f, .i_max_A = 12.0f},
        .sense = {.i_gain_A_count = 0.0125f, .i_offset_count = 2048.0f, .v_bus_gain_V_count = 0.1f},
        .guard = {.i_trip_A = 25.0f}};
}

// With what can be had beside.
static lode_drive_config_t rich(void) {
    lode_drive_config_t c = plain();
    c.inverter.dead_time_s = 2.0e-6f;
    c.inverter.pwm_ticks = 8400.0f;
    c.inverter.precharge_s = 1.0e-3f;
    c.sense.duty_max = 0.95f;
    c.sense.i_offset_count = 2000.0f;
    c.sense.temperature_gain_degC_count = 0.02f;
    c.estimator.emf.kind = LODE_EMF_FA_LESO;
    c.estimator.pll.kind = LODE_PLL_LESO;
    c.estimator.notch_k = 0.7f;
    c.references.kind = LODE_REFERENCES_MTPA;
    c.references.field_weakening = LODE_ON;
    c.references.v_regen_V = 230.0f;
    c.speed.every_period = LODE_ON;
    c.hfi.mode = LODE_HFI_ON;
    c.guard.stamp_per_period = 1000.0f;
    return c;
}

int main(void) {
    const lode_drive_config_t first = plain();
#ifdef EVA_PLAIN
    const lode_drive_config_t second = plain();
#else
    const lode_drive_config_t second = rich();
#endif
    const lode_status_t status = lode_drive_tune(&tunings[0], &first);
    //@ assert tuned: status == LODE_OK;
    const lode_status_t status_2 = lode_drive_tune(&tunings[1], &second);
    //@ assert tuned_2: status_2 == LODE_OK;
    // What is tuned is finite: tests/fuzz/fuzz_config.c.
    const lode_status_t begun = lode_drive_begin(&drive, &tunings[0]);
    //@ admit begun: begun == LODE_OK;
    while (any_bool()) {
        if (any_bool()) {
            const lode_command_t command = any_command();
            (void)lode_drive_post_command(&drive, &command);
        }
        if (any_bool()) {
            (void)lode_drive_post_tuning(&drive, &tunings[any_bool() ? 1 : 0]);
        }
        if (any_bool()) {
            lode_drive_limit_torque(&drive, any_float());
        }
        const lode_counts_t counts = any_counts();
        const lode_drive_out_t out = lode_drive_step(&drive, &counts);
        //@ assert duty_a: 0.0f <= out.duty.a <= 1.0f;
        //@ assert duty_b: 0.0f <= out.duty.b <= 1.0f;
        //@ assert duty_c: 0.0f <= out.duty.c <= 1.0f;
        //@ assert gates: out.gates == LODE_GATES_OFF || out.gates == LODE_GATES_ON || out.gates == LODE_GATES_LOW;
    }
    return 0;
}
