/// Why an init function refused its configuration.
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
    LODE_ERROR_MOTOR_SETS,        ///< sets neither 0, 1 nor 2
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
    LODE_ERROR_SENSE_TEMPERATURE, ///< temperature gain or offset not finite
    LODE_ERROR_SENSE_OFFSET,      ///< offsets or their tolerance outside the ADC's range
    LODE_ERROR_SENSE_WINDOW,      ///< duty_max outside 0.5 .. 1, or a window that is not built in
    LODE_ERROR_DOUBLE_UPDATE,     ///< double_update with low-side shunts, duty_max below 1
    LODE_ERROR_SENSE_CALIBRATION, ///< calibrate_s outside 1 period .. 10 s
    LODE_ERROR_EMF_KIND,          ///< emf not an enumerator of an observer that is built in
    LODE_ERROR_EMF_GI,            ///< gi_kappa outside 0 .. 7, or gi_wc_rad_s outside 0.01 .. 100
    LODE_ERROR_EMF_FA,            ///< k1 outside 0 .. 1e4 or above k2^2/10, or k2 outside 1 .. 1/Ts
    LODE_ERROR_EMF_W0,            ///< w0_rad_s outside 1 .. 2/Ts
    LODE_ERROR_PLL_KIND,          ///< pll not an enumerator
    LODE_ERROR_PLL_SIGMA,         ///< sigma outside 1 .. 0.3/Ts, or the low one above the high one
    LODE_ERROR_PLL_OBSERVER,      ///< sigma above what the EMF observer's w0 allows, C, GI: a fifth
    LODE_ERROR_NOTCH,             ///< width of a notch neither 0 nor 0.01 .. 2, or none built in
    LODE_ERROR_EMF_PLL, ///< k2 below 0.549 sigma (multi: 1.2): FA observer and PLL unstable together
    LODE_ERROR_W_FILTER,     ///< w_filter_rad_s outside 0 .. 1/Ts
    LODE_ERROR_PLL_SCHEDULE, ///< the speeds between which sigma rises are not in order
    LODE_ERROR_LAG,          ///< the observer's phase cannot be held within 0.01 degree
    LODE_ERROR_EMIN,         ///< emin_V outside 1e-4 .. 1e3
    LODE_ERROR_OMEGA_MAX,    ///< omega_max_rad_s outside 1 .. 0.5/Ts
    LODE_ERROR_CHOICE, ///< a choice is not LODE_AUTO, LODE_ON or LODE_OFF, or ON is not possible: start.signal_check with so small a pulse
    LODE_ERROR_LOCK_TIME,          ///< lock_s outside 1 period .. 1 s
    LODE_ERROR_CURRENT_BANDWIDTH,  ///< current bandwidth outside 1 .. 0.4/Ts
    LODE_ERROR_CURRENT_GAINS,      ///< current gains not positive, or unstable with the motor's L
    LODE_ERROR_CURRENT_VOLTAGE,    ///< use of the voltage circle outside 0.1 .. 1.1547
    LODE_ERROR_SPEED_GAINS,        ///< speed gains outside 0 .. 1e6
    LODE_ERROR_SPEED_BANDWIDTH,    ///< the speed loop is faster than the PLL that feeds it
    LODE_ERROR_SPEED_RAMP,         ///< acceleration not positive
    LODE_ERROR_SPEED_FEED_FORWARD, ///< share of a feed-forward outside 0 .. 1
    LODE_ERROR_ID_BIAS, ///< id bias or hfi.id_A neither LODE_NONE nor in 0 .. i_max_A, or its speeds not in order
    LODE_ERROR_REFERENCES,      ///< kind or field_weakening not an enumerator, or not built in
    LODE_ERROR_FIELD_WEAKENING, ///< voltage_use outside 0.1 .. 1, trim_rad_s 0.1 .. 1e3, release_s
                                ///< 1e-3 .. 10 or id_max_A 0.001 .. 1 times i_max_A
    LODE_ERROR_WEAKENING_ESTIMATOR, ///< field weakening with the GI-LESO or the QPLL, which cannot hold it
    LODE_ERROR_LQ_FALL,             ///< Lq_fall outside 0 .. 10/i_max_A
    LODE_ERROR_BUS_FADE, ///< v_bus_V <= v_regen_V < v_bus_max_V or v_bus_min_V < v_motor_V <= v_bus_V
                         ///< does not hold
    LODE_ERROR_START_CURRENT, ///< start current outside 0.001 .. 1 times i_max_A
    LODE_ERROR_START_SPEED, ///< hand-over speed outside 0 .. omega_max_rad_s, or speed.omega_min_rad_s below half of it
    LODE_ERROR_START_RAMP,        ///< start acceleration or a start time not positive
    LODE_ERROR_START_DAMPING,     ///< damping ratio outside 0 .. 2
    LODE_ERROR_GUARD_CURRENT,     ///< trip current below i_max_A, or beyond the sensor
    LODE_ERROR_GUARD_BUS,         ///< bus limits not around v_bus_V, or beyond the sensor
    LODE_ERROR_GUARD_TEMPERATURE, ///< temperature limit not finite
    LODE_ERROR_GUARD_SPEED,       ///< over-speed limit outside 1 .. 1e6
    LODE_ERROR_GUARD_TIME,        ///< a debounce time outside 1 period .. 10 s
    LODE_ERROR_HFI_MODE,          ///< hfi.mode not an enumerator, or not built in
    LODE_ERROR_HFI_SALIENCY,      ///< Lq'(i_max)/Ld below 1.15: injection would lose the d axis
    LODE_ERROR_HFI_VOLTAGE, ///< V_h_V outside 0 .. half the voltage circle, or noise_A not 0 .. i_max_A
    LODE_ERROR_HFI_DEAD_TIME, ///< V_h_V too small beside the voltage that the dead time takes
    LODE_ERROR_HFI_SPEEDS,    ///< not 0.1 <= w1 <= 0.95 w2, or w2 above omega_max_rad_s
    LODE_ERROR_HFI_SIGMA,     ///< sigma while injecting outside 1 .. 0.1/Ts
    LODE_ERROR_HFI_AXIS,      ///< k_x_rad_A turns the axis by more than 0.5 rad at i_max_A
    LODE_ERROR_HFI_LEARN, ///< hfi.learn not a lode_choice_t, on without injection or with six phases, or off where something shall be learned
    LODE_ERROR_HFI_FLUX, ///< injection with estimator.active_flux off: nothing would show the d axis
    LODE_ERROR_XY_INDUCTANCE, ///< Lxy_H outside 1e-7 .. 10
    LODE_ERROR_XY_BANDWIDTH, ///< xy bandwidth outside 1 .. 0.4/Ts, or resonance above a quarter of it
    LODE_ERROR_XY_VOLTAGE,   ///< share of the voltage for the xy plane outside 0 .. 0.5
    LODE_ERROR_SOURCE,       ///< source of the estimator not an enumerator
    LODE_ERROR_OPEN_PHASE,   ///< answer to an open phase not an enumerator
    LODE_ERROR_COMMAND,      ///< a command with an unknown mode or a value that is not finite
    LODE_ERROR_COMMAND_SPEED,  ///< a commanded speed above omega_max of the estimator or the guard
    LODE_ERROR_TUNING,         ///< a tuning with a float that is not finite
    LODE_ERROR_ENCODER_COUNTS, ///< counts per turn outside 6 .. 2^20
    LODE_ERROR_ENCODER_ANGLE,  ///< offset outside +-pi, or delay outside 0 .. 10 periods
    LODE_ERROR_ENCODER_BANDWIDTH, ///< bandwidth of the tracking loop outside 1 .. 1/Ts
    LODE_ERROR_ENCODER_CHECK,     ///< speed or time of the check by the EMF out of range
    LODE_ERROR_DERATE,            ///< a current, time or temperature of derating out of range
    LODE_ERROR_ACTIVE_SHORT, ///< supervisor: the short circuit's current psi/Ld is above i_max, or not built in
    LODE_ERROR_SUPPLY,  ///< a current limit of the supply or its time out of range
    LODE_ERROR_CHOPPER, ///< a voltage, resistance, power or time of the brake chopper out of range
    LODE_ERROR_SUPERVISOR, ///< supervisor: a reaction that is none, or a time out of range
    LODE_ERROR_CHANNELS,   ///< no channel, too many of them, or one that does not exist
    LODE_ERROR_BUFFER,     ///< a recorder's buffer holds less than two frames or rows
    LODE_ERROR_TRIGGER,    ///< trigger or its channel not an enumerator, or level not finite
    LODE_ERROR_PRE_SHARE,  ///< share of rows before the trigger outside 0 .. 1
    LODE_STATUS_COUNT      ///< number of statuses, none itself
} lode_status_t;

/// The enumerator's name, for logs; "LODE_STATUS_UNKNOWN" for any other value.
const char *lode_status_name(lode_status_t status);

#ifdef __cplusplus
}
#endif

#endif
