#include "config/schema.h"

#include "lodestar/status.h"

// Choices are stored as ints; the library's enums must have their size.
typedef char enum_is_int[sizeof(lode_choice_t) == sizeof(int) ? 1 : -1];

#define GIVEN(section, key, field)                                                                 \
    { section, key, RIG_KEY_GIVEN, offsetof(rig_config_t, drive.field), 0.0, 0.0, NULL, NULL }
#define PLAIN(section, key, field, kind)                                                           \
    { section, key, kind, offsetof(rig_config_t, field), 0.0, 0.0, NULL, NULL }
#define FLOAT(section, key, field)                                                                 \
    { section, key, RIG_KEY_FLOAT, offsetof(rig_config_t, drive.field), 0.0, 0.0, NULL, NULL }
#define FLOAT_OR_NONE(section, key, field)                                                         \
    {                                                                                              \
        section, key, RIG_KEY_FLOAT_OR_NONE, offsetof(rig_config_t, drive.field), 0.0, 0.0, NULL,  \
            NULL                                                                                   \
    }
#define CHOICE(section, key, field, names, later)                                                  \
    { section, key, RIG_KEY_CHOICE, offsetof(rig_config_t, field), 0.0, 0.0, names, later }
#define NUMBER(section, key, field, lo, hi)                                                        \
    { section, key, RIG_KEY_DOUBLE, offsetof(rig_config_t, field), lo, hi, NULL, NULL }
#define NUMBER_OR(section, key, field, lo, hi, word)                                               \
    { section, key, RIG_KEY_DOUBLE_OR, offsetof(rig_config_t, field), lo, hi, word, NULL }
#define TEXT(section, key, field)                                                                  \
    { section, key, RIG_KEY_TEXT, offsetof(rig_config_t, field), 0.0, 0.0, NULL, NULL }
#define SHEET(key, one, other, conversion, factor) NUMBER("motor", #key, sheet.key, 0.0, 1e9),
#define REACTION(key, check)                                                                       \
    CHOICE("supervisor", key, supervisor.reaction[LODE_CHECK_##check], "latch|again|ride-through", \
           NULL)
static const char emf_names[] =
#define LODE_OBSERVER(ID, id, name, STEP, vectors, numbers) name "|"
#include "lodestar/observers.def"
#undef LODE_OBSERVER
    "c-leso-euler|gi-leso-euler|fa-leso-euler";
#define PLL "leso-qpll|qpll|enhanced|leso-qpll-euler|qpll-euler|enhanced-euler"

// The rows of a section are contiguous; the names of a choice have the order of its enumerators.
static const rig_key_t keys[] = {
    GIVEN("motor", "pole_pairs", motor.pole_pairs),
    GIVEN("motor", "Rs_Ohm", motor.Rs_Ohm),
    GIVEN("motor", "Ld_H", motor.Ld_H),
    GIVEN("motor", "Lq_H", motor.Lq_H),
    GIVEN("motor", "psi_Wb", motor.psi_Wb),
    GIVEN("motor", "J_kgm2", motor.J_kgm2),
    GIVEN("motor", "B_Nms", motor.B_Nms),
    GIVEN("motor", "sets", motor.sets),
    PLAIN("motor", "Lxy_H", six.Lxy_H, RIG_KEY_GIVEN),
    NUMBER("motor", "speed_rated_rpm", people.speed_rated_rpm, 1e-3, 1e6),
    CHOICE("motor", "winding", sheet.winding, "star|delta", NULL),
    NUMBER("motor", "poles", sheet.poles, 2.0, 200.0),
    // clang-format off
    DATA_SHEET_VALUES(SHEET)
    // clang-format on

    GIVEN("drive", "f_pwm_Hz", f_pwm_Hz),
    GIVEN("drive", "v_bus_V", inverter.v_bus_V),
    GIVEN("drive", "i_max_A", inverter.i_max_A),
    GIVEN("drive", "dead_time_s", inverter.dead_time_s),
    GIVEN("drive", "v_drop_V", inverter.v_drop_V),
    GIVEN("drive", "r_on_Ohm", inverter.r_on_Ohm),
    FLOAT("drive", "i_dead_A", inverter.i_dead_A),
    GIVEN("drive", "pwm_ticks", inverter.pwm_ticks),
    FLOAT("drive", "precharge_s", inverter.precharge_s),
    CHOICE("drive", "dead_time_correction", drive.inverter.dead_time_correction, "auto|on|off",
           NULL),
    CHOICE("drive", "dead_time_model", drive.inverter.dead_time_model, "auto|on|off", NULL),
    CHOICE("drive", "double_update", drive.inverter.double_update, "auto|on|off", NULL),
    CHOICE("drive", "shunts", drive.sense.shunts, "three|two", NULL),
    NUMBER("drive", "adc_bits", board.adc_bits, 4.0, 16.0),
    NUMBER("drive", "i_range_A", board.i_range_A, 1e-3, 1e5),
    NUMBER("drive", "v_range_V", board.v_range_V, 0.1, 1e5),
    FLOAT("drive", "i_offset_tol_count", sense.i_offset_tol_count),
    FLOAT("drive", "duty_max", sense.duty_max),
    FLOAT("drive", "calibrate_s", sense.calibrate_s),
    FLOAT("drive", "i_noise_count", sense.i_noise_count),

    CHOICE("estimator", "emf", emf, emf_names, NULL),
    CHOICE("estimator", "pll", pll, PLL, NULL),
#define LODE_OBSERVER_FIELD(name) FLOAT("estimator", #name, estimator.emf.name),
#include "lodestar/observers.def"
#undef LODE_OBSERVER_FIELD
    FLOAT("estimator", "w_filter_rad_s", estimator.w_filter_rad_s),
    FLOAT("estimator", "notch_k", estimator.notch_k),
    FLOAT("estimator", "notch12_k", estimator.notch12_k),
    FLOAT("estimator", "sigma_rad_s", estimator.pll.sigma_rad_s),
    FLOAT("estimator", "sigma_low_rad_s", estimator.pll.sigma_low_rad_s),
    FLOAT("estimator", "omega_low_rad_s", estimator.pll.omega_low_rad_s),
    FLOAT("estimator", "omega_high_rad_s", estimator.pll.omega_high_rad_s),
    FLOAT("estimator", "emin_V", estimator.emin_V),
    FLOAT("estimator", "omega_max_rad_s", estimator.omega_max_rad_s),
    NUMBER("estimator", "speed_max_rpm", people.speed_max_rpm, 1e-3, 1e6),
    FLOAT("estimator", "lock_s", estimator.lock_s),
    CHOICE("estimator", "active_flux", drive.estimator.active_flux, "auto|on|off", NULL),
    CHOICE("estimator", "compensation", compensation, "auto|exact|none|eq30", NULL),
    CHOICE("estimator", "source", source, "own|truth|seeded|encoder", NULL),
    CHOICE("estimator", "winding", six.source, "vsd|set-1|set-2", NULL),
    NUMBER("estimator", "seeded_s", seeded_s, 0.0, 1e4),

    NUMBER("encoder", "counts_per_turn", encoder.counts_per_turn, 6.0, 1048576.0),
    NUMBER("encoder", "offset_deg", encoder.offset_deg, -180.0, 180.0),
    NUMBER("encoder", "bandwidth_rad_s", encoder.bandwidth_rad_s, 0.0, 1e6),
    CHOICE("encoder", "falls_back", encoder.falls_back, "off|on", NULL),

    CHOICE("adaptation", "J", adaptation.J, "off|on", NULL),
    CHOICE("adaptation", "psi", adaptation.psi, "off|on", NULL),
    CHOICE("adaptation", "Rs", adaptation.Rs, "off|on", NULL),

    CHOICE("hfi", "mode", drive.hfi.mode, "default|on|off|auto", NULL),
    FLOAT("hfi", "V_h_V", hfi.V_h_V),
    FLOAT("hfi", "w1_rad_s", hfi.w1_rad_s),
    FLOAT("hfi", "w2_rad_s", hfi.w2_rad_s),
    FLOAT("hfi", "sigma_rad_s", hfi.sigma_rad_s),
    GIVEN("hfi", "k_x_rad_A", hfi.k_x_rad_A),
    FLOAT("hfi", "Lq_i_max_H", hfi.Lq_i_max_H),
    FLOAT_OR_NONE("hfi", "id_A", hfi.id_A),
    FLOAT("hfi", "noise_A", hfi.noise_A),
    CHOICE("hfi", "learn", drive.hfi.learn, "auto|on|off", NULL),
    CHOICE("hfi", "silent", drive.hfi.silent, "auto|on|off", NULL),

    FLOAT("current", "bandwidth_rad_s", current.bandwidth_rad_s),
    FLOAT("current", "kp_d_V_A", current.kp_d_V_A),
    FLOAT("current", "kp_q_V_A", current.kp_q_V_A),
    FLOAT("current", "ki_d_V_As", current.ki_d_V_As),
    FLOAT("current", "ki_q_V_As", current.ki_q_V_As),
    FLOAT("current", "voltage_use", current.voltage_use),

    PLAIN("xy", "bandwidth_rad_s", six.xy.bandwidth_rad_s, RIG_KEY_FLOAT),
    PLAIN("xy", "resonance_rad_s", six.xy.resonance_rad_s, RIG_KEY_FLOAT_OR_NONE),
    PLAIN("xy", "voltage_share", six.xy.voltage_share, RIG_KEY_FLOAT),

    CHOICE("references", "strategy", drive.references.kind, "auto|id0|mtpa", NULL),
    CHOICE("references", "field_weakening", drive.references.field_weakening, "auto|on|off", NULL),
    FLOAT_OR_NONE("references", "id_bias_A", references.id_bias_A),
    FLOAT("references", "omega_low_rad_s", references.omega_low_rad_s),
    FLOAT("references", "omega_high_rad_s", references.omega_high_rad_s),
    FLOAT("references", "voltage_use", references.voltage_use),
    FLOAT_OR_NONE("references", "trim_rad_s", references.trim_rad_s),
    FLOAT("references", "release_s", references.release_s),
    FLOAT("references", "id_max_A", references.id_max_A),
    FLOAT("references", "Lq_fall", references.Lq_fall),
    FLOAT("references", "v_regen_V", references.v_regen_V),
    FLOAT("references", "v_motor_V", references.v_motor_V),
    FLOAT("references", "v_bus_max_V", references.v_bus_max_V),
    FLOAT("references", "v_bus_min_V", references.v_bus_min_V),

    FLOAT("speed", "kp_Nms", speed.kp_Nms),
    FLOAT("speed", "ki_Nm", speed.ki_Nm),
    NUMBER("speed", "kp_A_s_rad", people.kp_A_s_rad, 1e-9, 1e9),
    NUMBER("speed", "ki_A_rad", people.ki_A_rad, 1e-9, 1e9),
    FLOAT("speed", "bandwidth_rad_s", speed.bandwidth_rad_s),
    FLOAT("speed", "gain_rise", speed.gain_rise),
    FLOAT("speed", "ramp_rad_s2", speed.ramp_rad_s2),
    FLOAT("speed", "ramp_down_rad_s2", speed.ramp_down_rad_s2),
    FLOAT("speed", "jerk_rad_s3", speed.jerk_rad_s3),
    NUMBER("speed", "ramp_rpm_s", people.ramp_rpm_s, 1e-3, 1e9),
    FLOAT_OR_NONE("speed", "inertia_feed_forward", speed.inertia_feed_forward),
    FLOAT_OR_NONE("speed", "load_feed_forward", speed.load_feed_forward),
    FLOAT_OR_NONE("speed", "dip_gain", speed.dip_gain),
    FLOAT_OR_NONE("speed", "swing_Nm", speed.swing_Nm),
    CHOICE("speed", "every_period", drive.speed.every_period, "auto|on|off", NULL),
    FLOAT("speed", "omega_min_rad_s", speed.omega_min_rad_s),

    FLOAT("start", "current_A", start.current_A),
    FLOAT("start", "current_last_A", start.current_last_A),
    FLOAT("start", "omega_handover_rad_s", start.omega_handover_rad_s),
    NUMBER("start", "handover_rpm", people.handover_rpm, 1e-3, 1e6),
    FLOAT("start", "ramp_rad_s2", start.ramp_rad_s2),
    FLOAT("start", "current_rise_s", start.current_rise_s),
    FLOAT_OR_NONE("start", "damping", start.damping),
    FLOAT("start", "lock_s", start.lock_s),
    FLOAT("start", "align_s", start.align_s),
    FLOAT_OR_NONE("start", "catch_s", start.catch_s),
    FLOAT("start", "timeout_s", start.timeout_s),
    CHOICE("start", "measure", drive.start.measure, "auto|on|off", NULL),
    CHOICE("start", "pulses", drive.start.pulses, "auto|on|off", NULL),
    CHOICE("start", "signal_check", drive.start.signal_check, "auto|on|off", NULL),
    FLOAT("start", "fade_s", start.fade_s),

    FLOAT("guard", "i_trip_A", guard.i_trip_A),
    FLOAT("guard", "v_bus_max_V", guard.v_bus_max_V),
    FLOAT("guard", "v_bus_min_V", guard.v_bus_min_V),
    FLOAT("guard", "temperature_max_degC", guard.temperature_max_degC),
    FLOAT("guard", "omega_max_rad_s", guard.omega_max_rad_s),
    FLOAT("guard", "bus_s", guard.bus_s),
    FLOAT("guard", "lock_s", guard.lock_s),
    FLOAT("guard", "stamp_per_period", guard.stamp_per_period),
    FLOAT("guard", "temperature_min_degC", guard.temperature_min_degC),
    FLOAT("guard", "temperature_still_s", guard.temperature_still_s),
    FLOAT("guard", "bus_still_s", guard.bus_still_s),
    FLOAT_OR_NONE("guard", "overload_s", guard.overload_s),
    FLOAT_OR_NONE("guard", "i_sum_A", guard.i_sum_A),
    FLOAT_OR_NONE("guard", "flux_share", guard.flux_share),
    CHOICE("guard", "plausibility", drive.guard.plausibility, "auto|on|off", NULL),
    CHOICE("guard", "check_stuck", drive.guard.check_stuck, "auto|on|off", NULL),
    CHOICE("guard", "check_gain", drive.guard.check_gain, "auto|on|off", NULL),
    CHOICE("guard", "check_half_waves", drive.guard.check_half_waves, "auto|on|off", NULL),
    CHOICE("guard", "open_phase", six.open_phase, "trip|go-on|ignore", NULL),

    NUMBER("supervisor", "attempts", supervisor.attempts, 0.0, 255.0),
    NUMBER("supervisor", "wait_s", supervisor.wait_s, 1e-3, 1e4),
    NUMBER("supervisor", "good_s", supervisor.good_s, 1e-3, 1e5),
    CHOICE("supervisor", "active_short", supervisor.active_short, "auto|on|off", NULL),
    REACTION("hardware_trip", HARDWARE_TRIP),
    REACTION("over_current", OVER_CURRENT),
    REACTION("current_rail", CURRENT_RAIL),
    REACTION("over_voltage", OVER_VOLTAGE),
    REACTION("under_voltage", UNDER_VOLTAGE),
    REACTION("over_temperature", OVER_TEMPERATURE),
    REACTION("timing", TIMING),
    REACTION("non_finite", NON_FINITE),
    REACTION("over_speed", OVER_SPEED),
    REACTION("lost_lock", LOST_LOCK),
    REACTION("wrong_way", WRONG_WAY),
    REACTION("start", START),
    REACTION("offset", OFFSET),
    REACTION("open_phase", OPEN_PHASE),
    REACTION("current_stuck", CURRENT_STUCK),
    REACTION("current_sum", CURRENT_SUM),
    REACTION("under_temperature", UNDER_TEMPERATURE),
    REACTION("memory", MEMORY),
    REACTION("temperature_stuck", TEMPERATURE_STUCK),
    REACTION("bus_stuck", BUS_STUCK),
    REACTION("flux", FLUX),
    REACTION("resistance", RESISTANCE),
    REACTION("switch_shorted", SWITCH_SHORTED),
    REACTION("signals", SIGNALS),
    REACTION("inductance", INDUCTANCE),
    REACTION("overload", OVERLOAD),
    REACTION("current_gain", CURRENT_GAIN),
    REACTION("current_control", CURRENT_CONTROL),

    NUMBER("supply", "battery_A", supply.battery_A, 0.0, 1e5),
    NUMBER_OR("supply", "regen_A", supply.regen_A, 0.0, 1e5, "none"),
    NUMBER("supply", "correct_s", supply.correct_s, 1e-3, 100.0),

    NUMBER("derate", "i_continuous_A", derate.i_continuous_A, 1e-3, 1e5),
    NUMBER("derate", "winding_s", derate.winding_s, 0.1, 1e5),
    NUMBER("derate", "from_degC", derate.from_degC, -100.0, 300.0),
    NUMBER("derate", "to_degC", derate.to_degC, -40.0, 300.0),
    NUMBER("derate", "heat", derate.heat, 0.0, 4.0),

    NUMBER("chopper", "on_V", chopper.on_V, 1.0, 2e3),
    NUMBER("chopper", "full_V", chopper.full_V, 1.0, 4e3),
    NUMBER("chopper", "R_Ohm", chopper.R_Ohm, 1e-3, 1e5),
    NUMBER("chopper", "power_W", chopper.power_W, 1e-3, 1e7),
    NUMBER("chopper", "thermal_s", chopper.thermal_s, 1e-2, 1e5),

    NUMBER("plant", "Rs_Ohm", plant.Rs_Ohm, 0.0, 1e6),
    NUMBER("plant", "Ld_H", plant.Ld_H, 1e-9, 1e3),
    NUMBER("plant", "Lq_H", plant.Lq_H, 1e-9, 1e3),
    NUMBER("plant", "Lxy_H", plant.Lxy_H, 1e-9, 1e3),
    NUMBER("plant", "psi_Wb", plant.psi_Wb, 0.0, 1e3),
    NUMBER("plant", "J_kgm2", plant.J_kgm2, 1e-12, 1e6),
    NUMBER("plant", "B_Nms", plant.B_Nms, 0.0, 1e6),
    TEXT("plant", "flux_map", plant.flux_map),
    NUMBER("plant", "i_sat_A", plant.i_sat_A, 0.0, 1e6),
    NUMBER("plant", "Lq_sat_H", plant.Lq_sat_H, 1e-9, 1e3),
    NUMBER("plant", "id_sat_A", plant.id_sat_A, 0.0, 1e6),
    NUMBER("plant", "Ld_sat_H", plant.Ld_sat_H, 1e-9, 1e3),
    NUMBER("plant", "i_cross_A", plant.i_cross_A, 0.0, 1e6),
    NUMBER("plant", "Ldq_H", plant.Ldq_H, -1e3, 1e3),
    NUMBER("plant", "emf5_ratio", plant.emf5_ratio, 0.0, 1.0),
    NUMBER("plant", "emf5_phase_deg", plant.emf5_phase_deg, -360.0, 360.0),
    NUMBER("plant", "emf7_ratio", plant.emf7_ratio, 0.0, 1.0),
    NUMBER("plant", "emf7_phase_deg", plant.emf7_phase_deg, -360.0, 360.0),
    NUMBER("plant", "emf11_ratio", plant.emf11_ratio, 0.0, 1.0),
    NUMBER("plant", "emf11_phase_deg", plant.emf11_phase_deg, -360.0, 360.0),
    NUMBER("plant", "emf13_ratio", plant.emf13_ratio, 0.0, 1.0),
    NUMBER("plant", "emf13_phase_deg", plant.emf13_phase_deg, -360.0, 360.0),
    CHOICE("plant", "inverter", plant.inverter, "ideal|switched", NULL),
    CHOICE("plant", "load_kind", plant.load_kind, "passive|signed", NULL),
    NUMBER("plant", "load_ripple", plant.load_ripple, 0.0, 10.0),
    NUMBER("plant", "stiction_Nm", plant.stiction_Nm, 0.0, 1e6),
    NUMBER("plant", "fan_Nm", plant.fan_Nm, 0.0, 1e6),
    NUMBER("plant", "fan_rpm", plant.fan_rpm, 1e-3, 1e6),
    NUMBER("plant", "cogging_Nm", plant.cogging_Nm, 0.0, 1e6),
    NUMBER("plant", "cogging_per_turn", plant.cogging_per_turn, 0.0, 1e4),
    NUMBER("plant", "J_factor", plant.J_factor, 1e-3, 1e6),
    NUMBER("plant", "load_J_kgm2", plant.load_J_kgm2, 0.0, 1e6),
    NUMBER("plant", "shaft_Nm_rad", plant.shaft_Nm_rad, 1e-9, 1e9),
    NUMBER("plant", "shaft_Nms_rad", plant.shaft_Nms_rad, 0.0, 1e6),
    NUMBER("plant", "backlash_deg", plant.backlash_deg, 0.0, 360.0),
    NUMBER("plant", "v_bus_V", plant.v_bus_V, 0.1, 1e5),
    NUMBER("plant", "bus_C_F", plant.bus_C_F, 0.0, 1e3),
    NUMBER("plant", "chopper_R_Ohm", plant.chopper_R_Ohm, 1e-3, 1e9),
    NUMBER("plant", "dead_time_s", plant.dead_time_s, 0.0, 1.0),
    NUMBER("plant", "v_drop_V", plant.v_drop_V, 0.0, 100.0),
    NUMBER("plant", "v_diode_V", plant.v_diode_V, 0.0, 100.0),
    NUMBER("plant", "r_on_Ohm", plant.r_on_Ohm, 0.0, 1e3),
    NUMBER("plant", "pwm_ticks", plant.pwm_ticks, 0.0, 1e9),
    NUMBER("plant", "i_offset_a_A", plant.i_offset_A[0], -1e5, 1e5),
    NUMBER("plant", "i_offset_b_A", plant.i_offset_A[1], -1e5, 1e5),
    NUMBER("plant", "i_offset_c_A", plant.i_offset_A[2], -1e5, 1e5),
    NUMBER("plant", "i_offset_a2_A", plant.i_offset_A[3], -1e5, 1e5),
    NUMBER("plant", "i_offset_b2_A", plant.i_offset_A[4], -1e5, 1e5),
    NUMBER("plant", "i_offset_c2_A", plant.i_offset_A[5], -1e5, 1e5),
    NUMBER("plant", "i_gain_error_a", plant.i_gain_error[0], -0.5, 0.5),
    NUMBER("plant", "i_gain_error_b", plant.i_gain_error[1], -0.5, 0.5),
    NUMBER("plant", "i_gain_error_c", plant.i_gain_error[2], -0.5, 0.5),
    NUMBER("plant", "i_gain_error_a2", plant.i_gain_error[3], -0.5, 0.5),
    NUMBER("plant", "i_gain_error_b2", plant.i_gain_error[4], -0.5, 0.5),
    NUMBER("plant", "i_gain_error_c2", plant.i_gain_error[5], -0.5, 0.5),
    NUMBER("plant", "i_noise_A", plant.i_noise_A, 0.0, 1e5),
    NUMBER("plant", "i_noise_share", plant.i_noise_share, 0.0, 1.0),
    NUMBER("plant", "v_bus_noise_V", plant.v_bus_noise_V, 0.0, 1e5),
    NUMBER("plant", "temperature_noise_degC", plant.temperature_noise_degC, 0.0, 100.0),
    NUMBER("plant", "temperature_degC", plant.temperature_degC, -50.0, 150.0),
    NUMBER("plant", "sample_offset_s", plant.sample_offset_s, -1.0, 1.0),
    NUMBER_OR("plant", "theta0_deg", plant.theta0_deg, -360.0, 360.0, "random"),
    NUMBER("plant", "speed0_rpm", plant.speed0_rpm, -1e6, 1e6),
    NUMBER("plant", "Rs_spread", plant.Rs_spread, 0.0, 0.95),
    NUMBER("plant", "Lq_spread", plant.Lq_spread, 0.0, 0.95),
    NUMBER("plant", "J_spread", plant.J_spread, 0.0, 0.95),
    NUMBER("plant", "psi_spread", plant.psi_spread, 0.0, 0.95),
    NUMBER("plant", "i_offset_spread_A", plant.i_offset_spread_A, 0.0, 1e5),
    NUMBER("plant", "load_spread_Nm", plant.load_spread_Nm, -1e6, 1e6),

    TEXT("scenario", "motor", scenario.motor),
    TEXT("scenario", "drive", scenario.drive),
    TEXT("scenario", "plant", scenario.plant),
    NUMBER("scenario", "seed", scenario.seed, 0.0, 9007199254740992.0),
    NUMBER("scenario", "log_s", scenario.log_s, 1e-6, 1e3),
};

#define PHASE_NUMBER(key, field, lo, hi)                                                           \
    { "phase", key, RIG_KEY_DOUBLE, offsetof(rig_phase_t, field), lo, hi, NULL, NULL }
#define PHASE_NUMBER_OR(key, field, lo, hi, word)                                                  \
    { "phase", key, RIG_KEY_DOUBLE_OR, offsetof(rig_phase_t, field), lo, hi, word, NULL }
#define PHASE_CHOICE(key, field, names)                                                            \
    { "phase", key, RIG_KEY_CHOICE, offsetof(rig_phase_t, field), 0.0, 0.0, names, NULL }

static const rig_key_t phase_keys[] = {
    PHASE_NUMBER("duration_s", duration_s, 1e-3, 1e4),
    PHASE_CHOICE("mode", mode, "off|calibrate|voltage|current|run"),
    PHASE_NUMBER("speed_rpm", speed_rpm, -1e6, 1e6),
    PHASE_CHOICE("control", control, "speed|torque"),
    PHASE_NUMBER("torque_Nm", torque_Nm, -1e6, 1e6),
    PHASE_NUMBER("ramp_rpm_s", ramp_rpm_s, 1e-3, 1e9),
    PHASE_NUMBER("load_Nm", load_Nm, -1e6, 1e6),
    PHASE_NUMBER("v_bus_V", v_bus_V, 0.1, 1e5),
    PHASE_NUMBER("temperature_degC", temperature_degC, -50.0, 150.0),
    PHASE_NUMBER_OR("dyno_rpm", dyno_rpm, -1e6, 1e6, "free"),
    PHASE_CHOICE("trip", trip, "off|on|set-1|set-2"),
    PHASE_CHOICE("open_phase", open_phase, "a1|b1|c1|a2|b2|c2"),
    PHASE_CHOICE("shorted_switch", shorted, "low|high"),
    PHASE_CHOICE("clear_fault", clear_fault, "off|on"),
    PHASE_NUMBER("Lq_factor", Lq_factor, 0.01, 100.0),
    PHASE_NUMBER("Rs_factor", Rs_factor, 0.0, 100.0),
    PHASE_NUMBER("d", d, -1e5, 1e5),
    PHASE_NUMBER("q", q, -1e5, 1e5),
    PHASE_NUMBER("theta_deg", theta_deg, -360.0, 360.0),
    PHASE_NUMBER("omega_rad_s", omega_rad_s, -1e5, 1e5),
    PHASE_NUMBER("bar_dc_deg", bar_dc_deg, 0.0, 180.0),
    PHASE_NUMBER("bar_pp_deg", bar_pp_deg, 0.0, 360.0),
    PHASE_NUMBER("bar_error_deg", bar_error_deg, 0.0, 180.0),
    PHASE_NUMBER("bar_speed_rpm", bar_speed_rpm, 0.0, 1e6),
    PHASE_NUMBER("bar_torque_Nm", bar_torque_Nm, 0.0, 1e6),
    PHASE_NUMBER("bar_Lq_percent", bar_Lq_percent, 0.0, 1e3),
    PHASE_NUMBER("bar_battery_A", bar_battery_A, 0.0, 1e6),
    PHASE_NUMBER("bar_regen_A", bar_regen_A, 0.0, 1e6),
    PHASE_NUMBER("bar_v_bus_V", bar_v_bus_V, 0.0, 1e5),
    PHASE_NUMBER("bar_heat", bar_heat, 0.0, 4.0),
    PHASE_CHOICE("end_mode", end_mode, "off|calibrate|voltage|current|start|run|fault"),
};

typedef char keys_fit[sizeof keys / sizeof keys[0] <= RIG_KEYS_MAX ? 1 : -1];
typedef char
    phase_keys_fit[sizeof phase_keys / sizeof phase_keys[0] <= RIG_PHASE_KEYS_MAX ? 1 : -1];

rig_schema_t rig_schema(void) {
    return (rig_schema_t){keys, (int)(sizeof keys / sizeof keys[0])};
}

rig_schema_t rig_phase_schema(void) {
    return (rig_schema_t){phase_keys, (int)(sizeof phase_keys / sizeof phase_keys[0])};
}
