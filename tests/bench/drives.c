#include "drives.h"

typedef enum {
    OPTIONS_PLAIN,
    OPTIONS_NOTCH,
    OPTIONS_ALL,
    OPTIONS_FAST,
    OPTIONS_UNWATCHED,
    OPTIONS_NO_STUCK,
    OPTIONS_NO_GAIN,
    OPTIONS_NO_HALF_WAVES,
    OPTIONS_NO_SUM,
    OPTIONS_NO_OVERLOAD,
    OPTIONS_NO_FLUX
} options_t;
typedef enum { MACHINE_ROUND, MACHINE_SALIENT, MACHINE_BOARD, MACHINE_MTPA } machine_t;

typedef struct {
    bench_scene_t scene;
    lode_emf_kind_t emf;
    lode_pll_kind_t pll;
    options_t options;
    machine_t machine;
} case_t;

#define CASE(name, scene, emf, pll, options, machine)                                              \
    {BENCH_##scene, LODE_EMF_##emf, LODE_PLL_##pll, OPTIONS_##options, MACHINE_##machine},
static const case_t cases[BENCH_CASE_COUNT] = {BENCH_CASES(CASE)
#define LODE_OBSERVER(ID, id, name, STEP, vectors, numbers)                                        \
    CASE(id##_leso_qpll, STEADY, ID, LESO, PLAIN, ROUND)
#include "lodestar/observers.def"
#undef LODE_OBSERVER
};

lode_drive_t bench_drive[BENCH_CASE_COUNT];
static lode_drive_tuning_t tuning[BENCH_CASE_COUNT];

bench_scene_t bench_scene(int32_t number) {
    return cases[number].scene;
}

int32_t bench_settle(int32_t number) {
    switch (bench_scene(number)) {
    case BENCH_RISE:
        return BENCH_SETTLE_RISE;
    case BENCH_START:
        return BENCH_SETTLE_START;
    case BENCH_INJECTING:
        return BENCH_SETTLE_INJECTING;
    case BENCH_STEADY:
    case BENCH_SATURATED:
    case BENCH_FAULT:
    case BENCH_OFF:
    default:
        return BENCH_SETTLE;
    }
}

float bench_omega_rad_s(int32_t number) {
    return bench_scene(number) == BENCH_INJECTING ? BENCH_OMEGA_LOW_rad_s : BENCH_OMEGA_rad_s;
}

static void leave_out_check(lode_guard_config_t *guard, options_t options) {
    switch (options) {
    case OPTIONS_UNWATCHED:
        guard->plausibility = LODE_OFF;
        break;
    case OPTIONS_NO_STUCK:
        guard->check_stuck = LODE_OFF;
        break;
    case OPTIONS_NO_GAIN:
        guard->check_gain = LODE_OFF;
        break;
    case OPTIONS_NO_HALF_WAVES:
        guard->check_half_waves = LODE_OFF;
        break;
    case OPTIONS_NO_SUM:
        guard->i_sum_A = LODE_NONE;
        break;
    case OPTIONS_NO_OVERLOAD:
        guard->overload_s = LODE_NONE;
        break;
    case OPTIONS_NO_FLUX:
        guard->flux_share = LODE_NONE;
        break;
    case OPTIONS_PLAIN:
    case OPTIONS_NOTCH:
    case OPTIONS_ALL:
    case OPTIONS_FAST:
    default:
        break;
    }
}

static void add_options(lode_drive_config_t *config, options_t options) {
    if (options != OPTIONS_PLAIN) {
        config->estimator.notch_k = 0.7f;
    }
    if (options == OPTIONS_ALL) {
        config->estimator.notch12_k = 0.7f;
        config->estimator.w_filter_rad_s = 1000.0f;
        config->inverter.pwm_ticks = 8400.0f;
        config->inverter.r_on_Ohm = 1.0e-3f;
        config->guard.stamp_per_period = (float)BENCH_STAMP_PER_PERIOD;
    }
    leave_out_check(&config->guard, options);
    if (options == OPTIONS_FAST) { // more than 125 rad/s ask for every fourth period of 10 kHz
        config->speed.bandwidth_rad_s = 150.0f;
    }
}

static void add_machine(lode_drive_config_t *config, machine_t machine) {
    if (machine != MACHINE_ROUND) {
        config->motor.Ld_H = BENCH_LD_SALIENT_H;
    }
    if (machine == MACHINE_BOARD || machine == MACHINE_MTPA) {
        config->inverter.pwm_ticks = BENCH_PWM_TICKS;
        config->sense.duty_max = BENCH_DUTY_MAX;
        config->guard.stamp_per_period = (float)BENCH_STAMP_PER_PERIOD;
    }
    if (machine == MACHINE_MTPA) {
        config->references.kind = LODE_REFERENCES_MTPA;
        config->references.field_weakening = LODE_ON;
    }
}

lode_drive_config_t bench_config(int32_t number) {
    const case_t *c = &cases[number];
    lode_drive_config_t config = {
        .f_pwm_Hz = BENCH_F_PWM_Hz,
        .motor = {.pole_pairs = BENCH_POLE_PAIRS,
                  .Rs_Ohm = BENCH_RS_Ohm,
                  .Ld_H = BENCH_L_H,
                  .Lq_H = BENCH_L_H,
                  .psi_Wb = BENCH_PSI_Wb,
                  .J_kgm2 = BENCH_J_kgm2,
                  .B_Nms = 1.0e-5f,
                  .omega_rated_rad_s = 800.0f},
        .inverter = {.v_bus_V = BENCH_V_BUS_V,
                     .i_max_A = 2.0f * BENCH_IQ_A,
                     .dead_time_s = BENCH_DEAD_TIME_s,
                     .i_dead_A = BENCH_I_DEAD_A},
        // Wide enough to find the torque that the shaft takes, which is large for the inertia; 6 w
        // is still above eight times it, where the notch is in full.
        .estimator = {.emf = {.kind = c->emf}, .pll = {.kind = c->pll, .sigma_rad_s = 350.0f}},
        .sense = {.i_gain_A_count = BENCH_I_GAIN_A_count,
                  .i_offset_count = BENCH_I_OFFSET_count,
                  .v_bus_gain_V_count = BENCH_V_GAIN_V_count,
                  .temperature_gain_degC_count = 0.02f,
                  .calibrate_s = 1.0e-3f},
        // The vector of the start carries the rotor to the operating point itself, and its current
        // is about the torque there: nothing but the speed has to settle after the hand-over. Nothing is measured.
        .speed = {.bandwidth_rad_s = 80.0f,
                  .ki_Nm = 0.5f,
                  // Half the torque at the limit of current: BENCH_SATURATED is to get there.
                  .ramp_rad_s2 = 1.5f * BENCH_POLE_PAIRS * BENCH_PSI_Wb * BENCH_IQ_A / BENCH_J_kgm2,
                  .omega_min_rad_s = 0.5f * BENCH_OMEGA_rad_s},
        .start = {.current_A = BENCH_IQ_A,
                  .omega_handover_rad_s = BENCH_OMEGA_rad_s,
                  .ramp_rad_s2 = 2.0e4f,
                  .current_rise_s = 0.02f,
                  .lock_s = 0.02f,
                  .catch_s = LODE_NONE,
                  .fade_s = 0.01f,
                  .measure = LODE_OFF},
        // The bus of BENCH_SATURATED falls far.
        .guard = {.v_bus_min_V = 10.0f},
    };
    // Free, and as designed but for the times.
    if (c->scene == BENCH_RISE || c->scene == BENCH_START) {
        config.speed = (lode_speed_config_t){.omega_min_rad_s = 0.0f};
        config.start =
            (lode_start_config_t){.catch_s = LODE_NONE, .current_rise_s = 0.02f, .lock_s = 0.005f};
    }
    if (c->scene == BENCH_INJECTING) {
        config.hfi.mode = LODE_HFI_ON;
    }
    add_options(&config, c->options);
    add_machine(&config, c->machine);
    return config;
}

bool bench_begin(int32_t number) {
    const lode_drive_config_t config = bench_config(number);
    const lode_command_t run = {.mode = LODE_MODE_RUN,
                                .speed_rad_s = bench_omega_rad_s(number) / BENCH_POLE_PAIRS};
    lode_drive_t *drive = &bench_drive[number];
    return lode_drive_init(drive, &tuning[number], &config) == LODE_OK &&
           lode_drive_post_command(drive, &run) == LODE_OK;
}

void bench_settled(int32_t number) {
    lode_command_t command = {.mode = LODE_MODE_OFF};
    if (bench_scene(number) == BENCH_SATURATED) { // twice the speed that the brake lets it have
        command = (lode_command_t){.mode = LODE_MODE_RUN,
                                   .speed_rad_s = 2.0f * BENCH_OMEGA_rad_s / BENCH_POLE_PAIRS};
    } else if (bench_scene(number) != BENCH_OFF) {
        return;
    }
    (void)lode_drive_post_command(&bench_drive[number], &command);
}

static uint32_t bits_of(float x) {
    union {
        float value;
        uint32_t bits;
    } both = {x};
    return both.bits;
}

uint32_t bench_digest(lode_drive_out_t out) {
    const uint32_t sum = bits_of(out.duty.a) + 3u * bits_of(out.duty.b) + 5u * bits_of(out.duty.c);
    return 2u * sum + (out.gates ? 1u : 0u);
}

bool bench_estimate_is_good(int32_t number, const lode_telemetry_t *telemetry, float theta_rad) {
    const bool pushed = bench_scene(number) == BENCH_SATURATED;
    const bool injecting = bench_scene(number) == BENCH_INJECTING;
    const bool fresh = bench_scene(number) == BENCH_START; // the hand-over is at a lock of 0.7
    const float off_rad = lode_abs(lode_wrap(telemetry->theta_rad - theta_rad));
    const float slip = lode_abs(telemetry->omega_rad_s - BENCH_OMEGA_rad_s);
    return telemetry->lock > (pushed || injecting || fresh ? 0.7f : 0.9f) &&
           off_rad <= (pushed ? 0.3f : 0.1f) &&
           (bench_scene(number) != BENCH_STEADY || slip <= 0.015f * BENCH_OMEGA_rad_s);
}
