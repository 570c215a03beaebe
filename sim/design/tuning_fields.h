// Printed by tests/tools/tuning_fields.py from the headers; the test gate_tuning_fields compares.
// ROW(kind, type, member) of every scalar of a lode_drive_tuning_t; OBSERVER: the place for the type. TUNING6_FIELDS: of
// those that a lode_drive6_tuning_t has besides two of these. CONFIG_FIELDS, CONFIG6_FIELDS: the same of the configurations;
// CHOICE: an enumeration, and CONFIG_CHOICES(type, enumerator): what it may be.
// TUNING_OPTIONS(place, option): the members of a lode_drive_tuning_t that LODE_WITHOUT_<option> leaves out.
// clang-format off
#ifndef RIG_TUNING_FIELDS_H
#define RIG_TUNING_FIELDS_H

#define TUNING_FIELDS(ROW) \
    ROW(WHOLE, uint32_t, speed_periods) \
    ROW(FLOAT, float, omega_min) \
    ROW(FLOAT, float, sense.i_gain) \
    ROW(FLOAT, float, sense.alpha_gain) \
    ROW(FLOAT, float, sense.beta_gain) \
    ROW(INTEGER, int32_t, sense.offset_nominal) \
    ROW(INTEGER, int32_t, sense.offset_tol) \
    ROW(WHOLE, uint32_t, sense.alert) \
    ROW(FLOAT, float, sense.v_bus_gain) \
    ROW(FLOAT, float, sense.temperature_gain) \
    ROW(FLOAT, float, sense.temperature_offset) \
    ROW(FLOAT, float, sense.duty_max) \
    ROW(WHOLE, uint32_t, sense.calibrate_periods) \
    ROW(WHOLE, uint32_t, sense.noise_least) \
    ROW(WHOLE, uint_least16_t, sense.count_max) \
    ROW(WHOLE, uint_least16_t, sense.two_shunts) \
    ROW(FLOAT, float, inverter.v_min_V) \
    ROW(FLOAT, float, inverter.dead_duty) \
    ROW(FLOAT, float, inverter.dead_more_max) \
    ROW(FLOAT, float, inverter.v_drop_V) \
    ROW(FLOAT, float, inverter.i_dead_min_A) \
    ROW(FLOAT, float, inverter.i_dead_span_A) \
    ROW(FLOAT, float, inverter.ticks) \
    ROW(FLOAT, float, inverter.inv_ticks) \
    ROW(FLOAT, float, inverter.free) \
    ROW(WHOLE, uint32_t, inverter.precharge_periods) \
    ROW(WHOLE, uint_least16_t, inverter.correct) \
    ROW(WHOLE, uint_least16_t, inverter.grid) \
    ROW(WHOLE, uint32_t, estimator.options) \
    ROW(FLOAT, float, estimator.emf.inv_b) \
    ROW(FLOAT, float, estimator.emf.a_over_b) \
    ROW(FLOAT, float, estimator.emf.salient_Ohm) \
    ROW(WHOLE, uint32_t, estimator.emf.observer.kind) \
    ROW(OBSERVER, 0, estimator.emf.observer.own[0]) \
    ROW(OBSERVER, 1, estimator.emf.observer.own[1]) \
    ROW(OBSERVER, 2, estimator.emf.observer.own[2]) \
    ROW(OBSERVER, 3, estimator.emf.observer.own[3]) \
    ROW(OBSERVER, 4, estimator.emf.observer.own[4]) \
    ROW(FLOAT, float, estimator.pll.ts_s) \
    ROW(FLOAT, float, estimator.pll.inv_ts) \
    ROW(FLOAT, float, estimator.pll.x_low) \
    ROW(FLOAT, float, estimator.pll.x_rise) \
    ROW(FLOAT, float, estimator.pll.omega_low) \
    ROW(FLOAT, float, estimator.pll.inv_span) \
    ROW(WHOLE, uint32_t, estimator.pll.third_order) \
    ROW(FLOAT, float, estimator.lag.inv_range2) \
    ROW(FLOAT, float, estimator.lag.coefficient[0]) \
    ROW(FLOAT, float, estimator.lag.coefficient[1]) \
    ROW(FLOAT, float, estimator.lag.coefficient[2]) \
    ROW(FLOAT, float, estimator.lag.coefficient[3]) \
    ROW(FLOAT, float, estimator.lag.coefficient[4]) \
    ROW(FLOAT, float, estimator.lag.coefficient[5]) \
    ROW(FLOAT, float, estimator.hfi.V_h_V) \
    ROW(FLOAT, float, estimator.hfi.omega_high) \
    ROW(FLOAT, float, estimator.hfi.inv_span) \
    ROW(FLOAT, float, estimator.hfi.inv_full) \
    ROW(FLOAT, float, estimator.hfi.least_V2) \
    ROW(FLOAT, float, estimator.hfi.k_x) \
    ROW(FLOAT, float, estimator.hfi.iq_weight) \
    ROW(FLOAT, float, estimator.hfi.find_gain) \
    ROW(WHOLE, uint_least16_t, estimator.hfi.find_rounds) \
    ROW(WHOLE, uint_least16_t, estimator.hfi.silent) \
    ROW(FLOAT, float, estimator.notch.k) \
    ROW(FLOAT, float, estimator.notch.order_Ts) \
    ROW(FLOAT, float, estimator.notch.inv_span) \
    ROW(FLOAT, float, estimator.notch12_k) \
    ROW(FLOAT, float, estimator.w_weight) \
    ROW(FLOAT, float, estimator.emin_V) \
    ROW(FLOAT, float, estimator.omega_limit) \
    ROW(FLOAT, float, estimator.error_small) \
    ROW(FLOAT, float, estimator.droop_s2) \
    ROW(FLOAT, float, estimator.psi_Wb) \
    ROW(FLOAT, float, estimator.salient_H) \
    ROW(FLOAT, float, estimator.acc_per_torque) \
    ROW(FLOAT, float, estimator.acc_per_omega) \
    ROW(FLOAT, float, estimator.acc_most) \
    ROW(FLOAT, float, estimator.load_per_f_Nm) \
    ROW(FLOAT, float, estimator.lock_weight) \
    ROW(FLOAT, float, estimator.rotation_weight) \
    ROW(WHOLE, uint_least16_t, estimator.settle_rounds) \
    ROW(WHOLE, uint_least16_t, estimator.patience_rounds) \
    ROW(FLOAT, float, references.fade.high) \
    ROW(FLOAT, float, references.fade.slope) \
    ROW(FLOAT, float, references.id_bias_A) \
    ROW(FLOAT, float, references.i_max_A) \
    ROW(FLOAT, float, references.psi_Wb) \
    ROW(FLOAT, float, references.torque_factor) \
    ROW(WHOLE, uint32_t, references.options) \
    ROW(FLOAT, float, references.inv_torque_factor) \
    ROW(FLOAT, float, references.tau_max) \
    ROW(FLOAT, float, references.inv_psi2) \
    ROW(FLOAT, float, references.Ld_H) \
    ROW(FLOAT, float, references.inv_Ld) \
    ROW(FLOAT, float, references.Lq_H) \
    ROW(FLOAT, float, references.Lq_fall) \
    ROW(FLOAT, float, references.circle) \
    ROW(FLOAT, float, references.trim_gain) \
    ROW(FLOAT, float, references.trim_decay) \
    ROW(FLOAT, float, references.drop) \
    ROW(FLOAT, float, references.id_min_A) \
    ROW(FLOAT, float, references.fall_A) \
    ROW(FLOAT, float, references.rise_A) \
    ROW(FLOAT, float, references.regen.high) \
    ROW(FLOAT, float, references.regen.slope) \
    ROW(FLOAT, float, references.motor.high) \
    ROW(FLOAT, float, references.motor.slope) \
    ROW(FLOAT, float, current.d.kp) \
    ROW(FLOAT, float, current.d.ki_Ts) \
    ROW(FLOAT, float, current.q.kp) \
    ROW(FLOAT, float, current.q.ki_Ts) \
    ROW(FLOAT, float, current.circle) \
    ROW(WHOLE, uint32_t, current.weakens) \
    ROW(FLOAT, float, current.free) \
    ROW(FLOAT, float, speed.pi.kp) \
    ROW(FLOAT, float, speed.pi.ki_Ts) \
    ROW(FLOAT, float, speed.rise) \
    ROW(FLOAT, float, speed.inv_span) \
    ROW(FLOAT, float, speed.inv_pole_pairs) \
    ROW(FLOAT, float, speed.ramp_step) \
    ROW(FLOAT, float, speed.ramp_down_step) \
    ROW(FLOAT, float, speed.jerk_step) \
    ROW(FLOAT, float, speed.dip_gain) \
    ROW(FLOAT, float, speed.dip_least) \
    ROW(FLOAT, float, speed.swing_Nm) \
    ROW(FLOAT, float, speed.swing_calls) \
    ROW(FLOAT, float, speed.load_feed_forward) \
    ROW(FLOAT, float, speed.load_fall) \
    ROW(FLOAT, float, speed.inertia_Nm) \
    ROW(FLOAT, float, start.current_A) \
    ROW(FLOAT, float, start.current_step) \
    ROW(FLOAT, float, start.omega_handover) \
    ROW(FLOAT, float, start.omega_ready) \
    ROW(FLOAT, float, start.sweep_step_rad) \
    ROW(FLOAT, float, start.omega_step) \
    ROW(FLOAT, float, start.steepens) \
    ROW(FLOAT, float, start.damping) \
    ROW(FLOAT, float, start.damping_A) \
    ROW(FLOAT, float, start.damping_rad_s) \
    ROW(FLOAT, float, start.lost_per_A) \
    ROW(FLOAT, float, start.mean_weight) \
    ROW(FLOAT, float, start.swing_weight) \
    ROW(FLOAT, float, start.fade_step) \
    ROW(WHOLE, uint_least16_t, start.catch_rounds) \
    ROW(WHOLE, uint_least16_t, start.lock_rounds) \
    ROW(FLOAT, float, start.current_last_A) \
    ROW(FLOAT, float, start.still_rounds) \
    ROW(FLOAT, float, start.align_rounds) \
    ROW(WHOLE, uint32_t, start.timeout_rounds) \
    ROW(WHOLE, uint_least16_t, start.patience_rounds) \
    ROW(WHOLE, uint_least16_t, start.dwell_rounds) \
    ROW(FLOAT, float, start.omega_per_noise) \
    ROW(FLOAT, float, start.omega_most) \
    ROW(FLOAT, float, start.R_Ohm) \
    ROW(FLOAT, float, start.calm_V) \
    ROW(FLOAT, float, start.r_known) \
    ROW(FLOAT, float, start.dead_known) \
    ROW(FLOAT, float, fly.share_first) \
    ROW(FLOAT, float, fly.share_dead) \
    ROW(FLOAT, float, signal_check.pulse) \
    ROW(FLOAT, float, signal_check.mean_A_V) \
    ROW(FLOAT, float, signal_check.least_A_V) \
    ROW(FLOAT, float, signal_check.off_A) \
    ROW(FLOAT, float, signal_check.before_most) \
    ROW(FLOAT, float, signal_check.sum_most) \
    ROW(FLOAT, float, signal_check.turns_A) \
    ROW(FLOAT, float, signal_check.moves_A) \
    ROW(WHOLE, uint32_t, signal_check.pulses) \
    ROW(FLOAT, float, guard.i_trip) \
    ROW(FLOAT, float, guard.v_bus_max) \
    ROW(FLOAT, float, guard.v_bus_min) \
    ROW(FLOAT, float, guard.temperature_max) \
    ROW(FLOAT, float, guard.temperature_min) \
    ROW(FLOAT, float, guard.omega_max) \
    ROW(WHOLE, uint_least16_t, guard.bus_periods) \
    ROW(WHOLE, uint_least16_t, guard.lock_checks) \
    ROW(WHOLE, uint_least16_t, guard.still_rounds) \
    ROW(WHOLE, uint_least16_t, guard.bus_still_rounds) \
    ROW(WHOLE, uint32_t, guard.stamp_min) \
    ROW(WHOLE, uint32_t, guard.stamp_span) \
    ROW(FLOAT, float, plausibility.i_min_A2) \
    ROW(INTEGER, int32_t, plausibility.i_still) \
    ROW(INTEGER, int32_t, plausibility.i_sum) \
    ROW(FLOAT, float, plausibility.per_wave_A) \
    ROW(FLOAT, float, plausibility.frozen_A2) \
    ROW(FLOAT, float, plausibility.moves_A2) \
    ROW(FLOAT, float, plausibility.waves.least_A) \
    ROW(FLOAT, float, plausibility.waves.per_rad) \
    ROW(FLOAT, float, plausibility.waves.most) \
    ROW(FLOAT, float, plausibility.away_rad_s) \
    ROW(FLOAT, float, plausibility.away_step) \
    ROW(FLOAT, float, plausibility.stall_rad_s) \
    ROW(FLOAT, float, plausibility.taken_V) \
    ROW(FLOAT, float, plausibility.jump_V2) \
    ROW(WHOLE, uint32_t, plausibility.stall_rounds) \
    ROW(FLOAT, float, plausibility.flux_share) \
    ROW(FLOAT, float, plausibility.off_A2)

#define TUNING6_FIELDS(ROW) \
    ROW(FLOAT, float, xy.pi.kp) \
    ROW(FLOAT, float, xy.pi.ki_Ts) \
    ROW(FLOAT, float, xy.bandwidth_rad_s) \
    ROW(FLOAT, float, xy.corner_rad_s) \
    ROW(FLOAT, float, xy.ts_s) \
    ROW(FLOAT, float, xy.gain_Ohm_s) \
    ROW(FLOAT, float, xy.omega6_max) \
    ROW(FLOAT, float, xy.circle) \
    ROW(FLOAT, float, watch.least_A) \
    ROW(FLOAT, float, watch.per_rad) \
    ROW(FLOAT, float, watch.most) \
    ROW(WHOLE, uint_least16_t, source) \
    ROW(WHOLE, uint_least16_t, open_phase)

#define TUNING_OPTIONS(ROW) \
    ROW("estimator.hfi", "HFI") \
    ROW("estimator.notch", "NOTCH") \
    ROW("estimator.notch12_k", "NOTCH") \
    ROW("speed.ramp_down_step", "SHAPED_RAMP") \
    ROW("speed.jerk_step", "SHAPED_RAMP") \
    ROW("start.omega_per_noise", "PLAUSIBILITY") \
    ROW("start.omega_most", "PLAUSIBILITY") \
    ROW("start.R_Ohm", "START_MEASUREMENT") \
    ROW("start.calm_V", "START_MEASUREMENT") \
    ROW("start.r_known", "START_MEASUREMENT") \
    ROW("start.dead_known", "START_MEASUREMENT") \
    ROW("fly", "FLYING_START") \
    ROW("signal_check", "SIGNAL_CHECK") \
    ROW("plausibility", "PLAUSIBILITY")

#define CONFIG_FIELDS(ROW) \
    ROW(FLOAT, float, f_pwm_Hz) \
    ROW(FLOAT, float, motor.pole_pairs) \
    ROW(FLOAT, float, motor.Rs_Ohm) \
    ROW(FLOAT, float, motor.Ld_H) \
    ROW(FLOAT, float, motor.Lq_H) \
    ROW(FLOAT, float, motor.psi_Wb) \
    ROW(FLOAT, float, motor.J_kgm2) \
    ROW(FLOAT, float, motor.B_Nms) \
    ROW(FLOAT, float, motor.omega_rated_rad_s) \
    ROW(FLOAT, float, motor.sets) \
    ROW(FLOAT, float, inverter.v_bus_V) \
    ROW(FLOAT, float, inverter.i_max_A) \
    ROW(FLOAT, float, inverter.dead_time_s) \
    ROW(FLOAT, float, inverter.v_drop_V) \
    ROW(FLOAT, float, inverter.r_on_Ohm) \
    ROW(FLOAT, float, inverter.i_dead_A) \
    ROW(FLOAT, float, inverter.pwm_ticks) \
    ROW(CHOICE, lode_choice_t, inverter.dead_time_correction) \
    ROW(CHOICE, lode_choice_t, inverter.dead_time_model) \
    ROW(FLOAT, float, inverter.precharge_s) \
    ROW(CHOICE, lode_choice_t, inverter.double_update) \
    ROW(CHOICE, lode_shunts_t, sense.shunts) \
    ROW(FLOAT, float, sense.i_gain_A_count) \
    ROW(FLOAT, float, sense.i_offset_count) \
    ROW(FLOAT, float, sense.i_offset_tol_count) \
    ROW(FLOAT, float, sense.count_max) \
    ROW(FLOAT, float, sense.v_bus_gain_V_count) \
    ROW(FLOAT, float, sense.temperature_gain_degC_count) \
    ROW(FLOAT, float, sense.temperature_offset_degC) \
    ROW(FLOAT, float, sense.duty_max) \
    ROW(FLOAT, float, sense.calibrate_s) \
    ROW(FLOAT, float, sense.i_noise_count) \
    ROW(CHOICE, lode_emf_kind_t, estimator.emf.kind) \
    ROW(FLOAT, float, estimator.emf.w0_rad_s) \
    ROW(FLOAT, float, estimator.emf.gi_kappa) \
    ROW(FLOAT, float, estimator.emf.gi_wc_rad_s) \
    ROW(FLOAT, float, estimator.emf.k1_rad2_s2) \
    ROW(FLOAT, float, estimator.emf.k2_rad_s) \
    ROW(CHOICE, lode_pll_kind_t, estimator.pll.kind) \
    ROW(FLOAT, float, estimator.pll.sigma_rad_s) \
    ROW(FLOAT, float, estimator.pll.sigma_low_rad_s) \
    ROW(FLOAT, float, estimator.pll.omega_low_rad_s) \
    ROW(FLOAT, float, estimator.pll.omega_high_rad_s) \
    ROW(CHOICE, lode_lag_kind_t, estimator.compensation) \
    ROW(CHOICE, lode_choice_t, estimator.active_flux) \
    ROW(FLOAT, float, estimator.w_filter_rad_s) \
    ROW(FLOAT, float, estimator.notch_k) \
    ROW(FLOAT, float, estimator.notch12_k) \
    ROW(FLOAT, float, estimator.emin_V) \
    ROW(FLOAT, float, estimator.omega_max_rad_s) \
    ROW(FLOAT, float, estimator.lock_s) \
    ROW(CHOICE, lode_hfi_mode_t, hfi.mode) \
    ROW(FLOAT, float, hfi.V_h_V) \
    ROW(FLOAT, float, hfi.w1_rad_s) \
    ROW(FLOAT, float, hfi.w2_rad_s) \
    ROW(FLOAT, float, hfi.sigma_rad_s) \
    ROW(FLOAT, float, hfi.k_x_rad_A) \
    ROW(FLOAT, float, hfi.Lq_i_max_H) \
    ROW(FLOAT, float, hfi.id_A) \
    ROW(FLOAT, float, hfi.noise_A) \
    ROW(CHOICE, lode_choice_t, hfi.learn) \
    ROW(CHOICE, lode_choice_t, hfi.silent) \
    ROW(CHOICE, lode_references_kind_t, references.kind) \
    ROW(CHOICE, lode_choice_t, references.field_weakening) \
    ROW(FLOAT, float, references.id_bias_A) \
    ROW(FLOAT, float, references.omega_low_rad_s) \
    ROW(FLOAT, float, references.omega_high_rad_s) \
    ROW(FLOAT, float, references.voltage_use) \
    ROW(FLOAT, float, references.trim_rad_s) \
    ROW(FLOAT, float, references.release_s) \
    ROW(FLOAT, float, references.id_max_A) \
    ROW(FLOAT, float, references.Lq_fall) \
    ROW(FLOAT, float, references.v_regen_V) \
    ROW(FLOAT, float, references.v_motor_V) \
    ROW(FLOAT, float, references.v_bus_max_V) \
    ROW(FLOAT, float, references.v_bus_min_V) \
    ROW(FLOAT, float, current.bandwidth_rad_s) \
    ROW(FLOAT, float, current.kp_d_V_A) \
    ROW(FLOAT, float, current.kp_q_V_A) \
    ROW(FLOAT, float, current.ki_d_V_As) \
    ROW(FLOAT, float, current.ki_q_V_As) \
    ROW(FLOAT, float, current.voltage_use) \
    ROW(FLOAT, float, speed.kp_Nms) \
    ROW(FLOAT, float, speed.ki_Nm) \
    ROW(FLOAT, float, speed.bandwidth_rad_s) \
    ROW(FLOAT, float, speed.gain_rise) \
    ROW(FLOAT, float, speed.ramp_rad_s2) \
    ROW(FLOAT, float, speed.ramp_down_rad_s2) \
    ROW(FLOAT, float, speed.jerk_rad_s3) \
    ROW(FLOAT, float, speed.inertia_feed_forward) \
    ROW(FLOAT, float, speed.load_feed_forward) \
    ROW(FLOAT, float, speed.dip_gain) \
    ROW(FLOAT, float, speed.swing_Nm) \
    ROW(FLOAT, float, speed.omega_min_rad_s) \
    ROW(CHOICE, lode_choice_t, speed.every_period) \
    ROW(FLOAT, float, start.current_A) \
    ROW(FLOAT, float, start.current_last_A) \
    ROW(FLOAT, float, start.omega_handover_rad_s) \
    ROW(FLOAT, float, start.ramp_rad_s2) \
    ROW(FLOAT, float, start.current_rise_s) \
    ROW(FLOAT, float, start.damping) \
    ROW(FLOAT, float, start.lock_s) \
    ROW(FLOAT, float, start.align_s) \
    ROW(FLOAT, float, start.catch_s) \
    ROW(FLOAT, float, start.timeout_s) \
    ROW(CHOICE, lode_choice_t, start.measure) \
    ROW(CHOICE, lode_choice_t, start.pulses) \
    ROW(CHOICE, lode_choice_t, start.signal_check) \
    ROW(FLOAT, float, start.fade_s) \
    ROW(FLOAT, float, guard.i_trip_A) \
    ROW(FLOAT, float, guard.v_bus_max_V) \
    ROW(FLOAT, float, guard.v_bus_min_V) \
    ROW(FLOAT, float, guard.temperature_max_degC) \
    ROW(FLOAT, float, guard.omega_max_rad_s) \
    ROW(FLOAT, float, guard.bus_s) \
    ROW(FLOAT, float, guard.lock_s) \
    ROW(FLOAT, float, guard.stamp_per_period) \
    ROW(FLOAT, float, guard.temperature_min_degC) \
    ROW(FLOAT, float, guard.i_sum_A) \
    ROW(CHOICE, lode_choice_t, guard.plausibility) \
    ROW(FLOAT, float, guard.temperature_still_s) \
    ROW(FLOAT, float, guard.bus_still_s) \
    ROW(FLOAT, float, guard.overload_s) \
    ROW(FLOAT, float, guard.flux_share) \
    ROW(CHOICE, lode_choice_t, guard.check_stuck) \
    ROW(CHOICE, lode_choice_t, guard.check_gain) \
    ROW(CHOICE, lode_choice_t, guard.check_half_waves)

#define CONFIG6_FIELDS(ROW) \
    ROW(FLOAT, float, Lxy_H) \
    ROW(CHOICE, lode_source_t, source) \
    ROW(FLOAT, float, xy.bandwidth_rad_s) \
    ROW(FLOAT, float, xy.resonance_rad_s) \
    ROW(FLOAT, float, xy.voltage_share) \
    ROW(CHOICE, lode_open_phase_response_t, open_phase)

#define CONFIG_CHOICES(ROW) \
    ROW(lode_choice_t, LODE_AUTO) \
    ROW(lode_choice_t, LODE_ON) \
    ROW(lode_choice_t, LODE_OFF) \
    ROW(lode_shunts_t, LODE_SHUNTS_THREE) \
    ROW(lode_shunts_t, LODE_SHUNTS_TWO) \
    ROW(lode_emf_kind_t, LODE_EMF_C_LESO) \
    ROW(lode_emf_kind_t, LODE_EMF_GI_LESO) \
    ROW(lode_emf_kind_t, LODE_EMF_FA_LESO) \
    ROW(lode_emf_kind_t, LODE_EMF_FA_MULTI) \
    ROW(lode_emf_kind_t, LODE_EMF_R_LESO) \
    ROW(lode_pll_kind_t, LODE_PLL_LESO) \
    ROW(lode_pll_kind_t, LODE_PLL_QPLL) \
    ROW(lode_lag_kind_t, LODE_LAG_EXACT) \
    ROW(lode_lag_kind_t, LODE_LAG_NONE) \
    ROW(lode_lag_kind_t, LODE_LAG_EQ30) \
    ROW(lode_hfi_mode_t, LODE_HFI_DEFAULT) \
    ROW(lode_hfi_mode_t, LODE_HFI_ON) \
    ROW(lode_hfi_mode_t, LODE_HFI_OFF) \
    ROW(lode_hfi_mode_t, LODE_HFI_AUTO) \
    ROW(lode_references_kind_t, LODE_REFERENCES_AUTO) \
    ROW(lode_references_kind_t, LODE_REFERENCES_ID0) \
    ROW(lode_references_kind_t, LODE_REFERENCES_MTPA) \
    ROW(lode_source_t, LODE_SOURCE_VSD) \
    ROW(lode_source_t, LODE_SOURCE_SET_1) \
    ROW(lode_source_t, LODE_SOURCE_SET_2) \
    ROW(lode_open_phase_response_t, LODE_OPEN_PHASE_TRIP) \
    ROW(lode_open_phase_response_t, LODE_OPEN_PHASE_GO_ON) \
    ROW(lode_open_phase_response_t, LODE_OPEN_PHASE_IGNORE)

#endif
