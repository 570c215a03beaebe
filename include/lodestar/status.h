/// Status of init, tune and post functions: LODE_OK, or why the input was refused.
#ifndef LODESTAR_STATUS_H
#define LODESTAR_STATUS_H

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    LODE_OK = 0,
    LODE_ERROR_NULL,              ///< a pointer argument is NULL
    LODE_ERROR_F_PWM,             ///< f_pwm_Hz outside 1 kHz .. 200 kHz
    LODE_ERROR_MOTOR_POLE_PAIRS,  ///< pole_pairs outside 1 .. 100
    LODE_ERROR_MOTOR_RS,          ///< Rs_Ohm outside 0 .. 1e3
    LODE_ERROR_MOTOR_LD,          ///< Ld_H outside 1e-7 .. 10
    LODE_ERROR_MOTOR_LQ,          ///< Lq_H outside 1e-7 .. 10
    LODE_ERROR_MOTOR_PSI,         ///< psi_Wb outside 1e-6 .. 100
    LODE_ERROR_MOTOR_J,           ///< J_kgm2 outside 1e-9 .. 1e4
    LODE_ERROR_MOTOR_B,           ///< B_Nms outside 0 .. 1e3 or above J/Ts
    LODE_ERROR_MOTOR_OMEGA,       ///< omega_rated_rad_s neither 0 nor within 1 .. 1e5
    LODE_ERROR_MOTOR_SETS,        ///< sets not 0, 1 or 2, or six phases for a function of three
    LODE_ERROR_MOTOR_PERIOD,      ///< R/L so large that the current settles within one period
    LODE_ERROR_V_BUS,             ///< v_bus_V outside 1 .. 2000
    LODE_ERROR_I_MAX,             ///< i_max_A outside 1e-3 .. 1e4
    LODE_ERROR_DEAD_TIME,         ///< dead_time_s outside 0 .. 0.2 periods
    LODE_ERROR_V_DROP,            ///< v_drop_V outside 0 .. 10
    LODE_ERROR_R_ON,              ///< r_on_Ohm outside 0 .. 10
    LODE_ERROR_I_DEAD,            ///< i_dead_A outside 1e-3 .. 1 times i_max_A
    LODE_ERROR_PWM_TICKS,         ///< pwm_ticks outside 0 .. 65535
    LODE_ERROR_PRECHARGE,         ///< precharge_s outside 0 .. 1
    LODE_ERROR_SENSE_SHUNTS,      ///< shunts not an enumerator
    LODE_ERROR_SENSE_CURRENT,     ///< current gain zero or not finite, or its range below i_max_A
    LODE_ERROR_SENSE_BUS,         ///< bus gain not positive, or its range below v_bus_V
    LODE_ERROR_SENSE_TEMPERATURE, ///< temperature gain outside +-1e3, or offset outside +-1e6
    LODE_ERROR_SENSE_OFFSET, ///< offset or tolerance outside 0 .. count_max, or count_max outside 1 .. 65535
    /// duty_max outside 0.5 .. 1, not built in, or current.voltage_use too large for two or one shunts
    LODE_ERROR_SENSE_WINDOW,
    LODE_ERROR_DOUBLE_UPDATE, ///< double_update with low-side shunts, duty_max below 1
    LODE_ERROR_SENSE_CALIBRATION, ///< calibrate_s outside 1 period .. 10 s, or i_noise_count out of range
    LODE_ERROR_EMF_KIND,          ///< emf.kind not an enumerator, or not built in
    LODE_ERROR_EMF_GI,            ///< gi_kappa outside 0 .. 7, or gi_wc_rad_s outside 0.01 .. 100
    LODE_ERROR_EMF_FA,            ///< k1 outside 0 .. 1e4 or above k2^2/10, or k2 outside 1 .. 1/Ts
    LODE_ERROR_EMF_W0,            ///< w0_rad_s outside 1 .. 2/Ts
    LODE_ERROR_PLL_KIND,          ///< pll.kind not an enumerator
    LODE_ERROR_PLL_SIGMA,         ///< sigma outside 1 .. 0.3/Ts, or sigma_low above sigma
    LODE_ERROR_PLL_OBSERVER, ///< sigma above what the EMF observer allows; C-LESO, GI-LESO: w0/5
    LODE_ERROR_NOTCH,        ///< width of a notch neither 0 nor 0.01 .. 2, or not built in
    /// k2 below 0.549 sigma (multi-mode 0.6): FA observer and PLL are unstable together
    LODE_ERROR_EMF_PLL,
    LODE_ERROR_W_FILTER,     ///< w_filter_rad_s outside 0 .. 1/Ts
    LODE_ERROR_PLL_SCHEDULE, ///< omega_low_rad_s not below omega_high_rad_s
    LODE_ERROR_LAG, ///< kind unknown, or the fit of the observer's lag is off by more than 0.01 degree
    LODE_ERROR_EMIN,      ///< emin_V outside 1e-4 .. 1e3
    LODE_ERROR_OMEGA_MAX, ///< omega_max_rad_s outside 1 .. 0.5/Ts
    /// a choice is not LODE_AUTO, LODE_ON or LODE_OFF, or ON is not possible, as start.signal_check with too small
    /// a pulse
    LODE_ERROR_CHOICE,
    LODE_ERROR_LOCK_TIME,         ///< lock_s outside 1 period .. 1 s
    LODE_ERROR_CURRENT_BANDWIDTH, ///< current bandwidth outside 1 .. 0.4/Ts
    LODE_ERROR_CURRENT_GAINS,     ///< current gains out of range, or unstable with the motor's L
    LODE_ERROR_CURRENT_VOLTAGE,   ///< current.voltage_use outside 0.1 .. 1.1547
    LODE_ERROR_SPEED_GAINS, ///< kp outside 1e-9 .. 1e6, ki outside 0 .. 1e6, gain_rise outside 1 .. 10, dip_gain outside 0 .. 10, or swing_Nm outside 0 .. 1e6
    LODE_ERROR_SPEED_BANDWIDTH, ///< speed bandwidth out of range, or above the PLL's
    LODE_ERROR_SPEED_RAMP, ///< a ramp outside 1e-3 .. 1e7, or a jerk out of range or not built in
    LODE_ERROR_SPEED_FEED_FORWARD, ///< a feed-forward neither 0 .. 1 nor LODE_NONE
    /// id_bias_A or hfi.id_A neither 0 .. i_max_A nor LODE_NONE, or omega_low_rad_s not below omega_high_rad_s
    LODE_ERROR_ID_BIAS,
    LODE_ERROR_REFERENCES,      ///< kind or field_weakening not an enumerator, or not built in
    LODE_ERROR_FIELD_WEAKENING, ///< voltage_use outside 0.1 .. 1, trim_rad_s 0.1 .. 1e3, release_s
                                ///< 1e-3 .. 10 or id_max_A 0.001 .. 1 times i_max_A
    /// field weakening with the GI-LESO or the QPLL, which do not hold the angle there
    LODE_ERROR_WEAKENING_ESTIMATOR,
    LODE_ERROR_LQ_FALL, ///< Lq_fall outside 0 .. 10/i_max_A
    LODE_ERROR_BUS_FADE, ///< v_bus_V <= v_regen_V < v_bus_max_V or v_bus_min_V < v_motor_V <= v_bus_V
                         ///< does not hold
    LODE_ERROR_START_CURRENT, ///< a start current outside 0.001 .. 1 times i_max_A, or the last one below it
    /// hand-over speed outside 0.001 .. 1 times omega_max_rad_s, or speed.omega_min_rad_s below half of it or above
    /// omega_max_rad_s
    LODE_ERROR_START_SPEED,
    LODE_ERROR_START_RAMP,    ///< start acceleration or a time of the start out of range
    LODE_ERROR_START_DAMPING, ///< damping neither 0 .. 2 nor LODE_NONE
    LODE_ERROR_GUARD_CURRENT, ///< trip current below i_max_A or beyond the sensor, or i_sum_A out of range
    LODE_ERROR_GUARD_BUS,         ///< bus limits that do not enclose v_bus_V, or beyond the sensor
    LODE_ERROR_GUARD_TEMPERATURE, ///< temperature limits out of range or not in order, or the temperature without a sensor is not between them
    LODE_ERROR_GUARD_SPEED, ///< over-speed limit outside 1 .. 1e6, or below hand-over or least speed
    LODE_ERROR_GUARD_TIME, ///< a time of the guard, or stamp_per_period, out of range; or temperature_still_s without a sensor
    LODE_ERROR_GUARD_FLUX,   ///< flux_share neither 0.1 .. 1 nor LODE_NONE
    LODE_ERROR_HFI_MODE,     ///< hfi.mode not an enumerator, or not built in
    LODE_ERROR_HFI_SALIENCY, ///< Lq'(i_max)/Ld below 1.15: injection would lose the d axis
    LODE_ERROR_HFI_VOLTAGE, ///< V_h_V outside 0 .. half the voltage circle, or noise_A not 0 .. i_max_A
    LODE_ERROR_HFI_DEAD_TIME, ///< V_h_V too small for the voltage that dead time takes
    LODE_ERROR_HFI_SPEEDS,    ///< not 0.1 <= w1 <= 0.95 w2, or w2 above omega_max_rad_s
    LODE_ERROR_HFI_SIGMA,     ///< PLL bandwidth with injection outside 1 .. 0.1/Ts
    LODE_ERROR_HFI_AXIS,      ///< k_x_rad_A turns the axis by more than 0.5 rad at i_max_A
    /// hfi.learn not a lode_choice_t, on without injection or with six phases, or off for lode_learn_design()
    LODE_ERROR_HFI_LEARN,
    LODE_ERROR_HFI_FLUX, ///< injection with estimator.active_flux off: the d axis could not be seen
    LODE_ERROR_XY_INDUCTANCE, ///< Lxy_H outside 1e-7 .. 10
    LODE_ERROR_XY_BANDWIDTH, ///< xy bandwidth outside 1 .. 0.4/Ts, or resonance above a quarter of it
    LODE_ERROR_XY_VOLTAGE,   ///< xy.voltage_share outside 0 .. 0.5
    LODE_ERROR_SOURCE,       ///< source not an enumerator
    LODE_ERROR_OPEN_PHASE,   ///< open_phase not an enumerator
    LODE_ERROR_COMMAND, ///< unknown mode or control, a value not finite, or clear_fault without OFF
    LODE_ERROR_COMMAND_SPEED,     ///< commanded speed above omega_max_rad_s of estimator or guard
    LODE_ERROR_TUNING,            ///< tuning with a value that is not finite
    LODE_ERROR_ENCODER_COUNTS,    ///< counts per turn outside 6 .. 2^20
    LODE_ERROR_ENCODER_ANGLE,     ///< offset outside +-pi, or delay outside 0 .. 10 periods
    LODE_ERROR_ENCODER_BANDWIDTH, ///< bandwidth of the tracking loop outside 1 .. 1/Ts
    LODE_ERROR_ENCODER_CHECK,     ///< speed or time of the sensor check by the EMF out of range
    LODE_ERROR_DERATE,            ///< a current, time or temperature of derating out of range
    /// supervisor: the current of the active short, psi/Ld, is above i_max, or it is not built in
    LODE_ERROR_ACTIVE_SHORT,
    LODE_ERROR_SUPPLY,  ///< a current limit of the supply or its time out of range
    LODE_ERROR_CHOPPER, ///< a voltage, resistance, power or time of the brake chopper out of range
    LODE_ERROR_SUPERVISOR, ///< supervisor: unknown reaction, or a time out of range
    LODE_ERROR_CHANNELS,   ///< no channel, too many channels, or an unknown one
    LODE_ERROR_BUFFER, ///< buffer of a recorder too small, or rows and faults of a fault log out of range
    LODE_ERROR_TRIGGER,   ///< trigger or its channel not an enumerator, or level not finite
    LODE_ERROR_PRE_SHARE, ///< pre_share outside 0 .. 1
    LODE_STATUS_COUNT     ///< number of statuses
} lode_status_t;

/// The enumerator's name, for logs; "LODE_STATUS_UNKNOWN" for any other value.
const char *lode_status_name(lode_status_t status);

#ifdef __cplusplus
}
#endif

#endif
