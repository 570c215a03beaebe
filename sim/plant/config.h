/// The plant's configuration: motor, shaft, inverter and sensors.
///
/// SI units, with the unit's symbol at the end of each name. Zero switches an effect off where that is
/// meaningful.
#ifndef PLANT_CONFIG_H
#define PLANT_CONFIG_H

#include <stdbool.h>
#include <stdint.h>

#include "plant/map.h"

enum {
    PLANT_PHASES = 3,                       ///< of one set
    PLANT_SETS = 2,                         ///< at most
    PLANT_LEGS = PLANT_PHASES * PLANT_SETS, ///< phases a b c of the first set, then of the second
    PLANT_LINKS = 2                         ///< samples of the DC link's shunt per period
};

/// How detailed the inverter model is.
typedef enum {
    /// duty * v_bus on each phase through the whole period; no dead time, no drops, no ripple.
    /// Currents at t_k are those of the switching inverter's zero-vector samples, less ripple.
    PLANT_AVERAGED,
    /// Every gate edge, dead time, on-state drops, currents that stop at zero.
    PLANT_SWITCHING
} plant_level_t;

typedef struct {
    // Motor, amplitude-invariant dq, d on the magnet's flux.
    int sets; ///< 2: two sets of windings 30 degrees apart, each with its own neutral; else one
    int pole_pairs;  ///< 1 and up
    double Rs_Ohm;   ///< winding resistance per phase, 0 and up
    double Ld_H;     ///< above 0
    double Lq_H;     ///< unsaturated, above 0
    double Lxy_H;    ///< two sets: inductance of the xy plane, above 0
    double psi_Wb;   ///< magnet flux linkage, 0 and up
    double i_sat_A;  ///< q saturation: Lq_H falls towards Lq_sat_H around this current; 0: linear
    double Lq_sat_H; ///< Lq at infinite current, 0 < Lq_sat_H <= Lq_H
    double id_sat_A; ///< d saturation around this current; 0: linear
    double Ld_sat_H; ///< differential Ld at infinite positive id, 0 < Ld_sat_H <= Ld_H
    /// Cross-saturation: the differential cross-inductance dpsi_d/diq is largest, -Ldq_H, at this iq
    /// (and id = 0); 0: none.
    double i_cross_A;
    double Ldq_H; ///< of either sign
    /// Fluxes of a grid of currents in place of the laws above; Ld_H, Lq_H and psi_Wb are then the map's
    /// own. It must outlive the plant. NULL: none.
    const plant_map_t *map;
    /// EMF harmonics in phase a: -w psi (sin th + r5 sin(5 th + p5) + ...). With two sets the 5th and
    /// 7th lie in the xy plane.
    double emf5_ratio, emf5_phase_rad;
    double emf7_ratio, emf7_phase_rad;
    double emf11_ratio, emf11_phase_rad;
    double emf13_ratio, emf13_phase_rad;

    // Shaft.
    double J_kgm2;            ///< above 0
    double B_Nms;             ///< viscous friction, 0 and up
    double load_Nm;           ///< at the start; see plant_set_load
    bool load_is_passive;     ///< true: opposes motion and holds; false: signed, may drive
    double load_ripple;       ///< share by which load_Nm swings once per mechanical turn, 0 and up
    double stiction_Nm;       ///< held at standstill on top of a passive load, 0 and up
    double fan_Nms2;          ///< load torque per square of the mechanical speed, 0 and up
    double cogging_Nm;        ///< amplitude of a torque that follows the rotor's angle, 0 and up
    double cogging_per_turn;  ///< periods per mechanical turn
    double load_J_kgm2;       ///< inertia of a second mass, on which the load acts; 0: none
    double shaft_Nm_rad;      ///< stiffness between the masses, above 0 with two masses
    double shaft_Nms_rad;     ///< damping between them, 0 and up
    double backlash_rad;      ///< mechanical angle between one flank and the other, 0 and up
    bool speed_is_prescribed; ///< true: a dynamometer holds omega_m; see plant_set_speed
    double theta_e_rad;       ///< at the start
    double omega_m_rad_s;     ///< at the start, mechanical

    // Inverter.
    plant_level_t level;
    double period_s;    ///< from call to call: a PWM period
    bool double_update; ///< or half of one
    double v_bus_V;     ///< at the start; see plant_set_bus
    /// capacitor after a rectifier, which charges it to v_bus_V and takes no energy back; 0: a stiff source,
    /// for example a battery. Updated once per period; needs keeps_accounts
    double bus_C_F;
    double
        chopper_R_Ohm;  ///< brake resistor across the capacitor; see plant_write_chopper(); 0: none
    double dead_time_s; ///< 0 up to a quarter of the period
    double v_transistor_V; ///< on-state drop at zero current
    double v_diode_V;      ///< the same of the diode across it
    double r_on_Ohm;       ///< slope of both
    uint32_t pwm_ticks;    ///< duty steps per period; 0: not quantised (both levels)

    // Analogue-to-digital conversion.
    int adc_bits;                      ///< 4..16
    double i_A_per_count;              ///< nominal; 0 A is half of full scale
    double i_offset_A[PLANT_LEGS];     ///< error, per phase
    double i_gain_error[PLANT_LEGS];   ///< relative error, per phase
    double i_noise_A;                  ///< Gaussian, rms
    double v_bus_V_per_count;          ///< nominal; 0 V is count 0
    double v_bus_noise_V;              ///< Gaussian, rms
    double temperature_noise_degC;     ///< Gaussian, rms
    double temperature_degC_per_count; ///< nominal
    double temperature_zero_degC;      ///< at count 0
    double temperature_degC;           ///< at the start; see plant_set_temperature
    /// Sampling instant relative to t_k, within half a period either way.
    double sample_offset_s;
    uint64_t seed;   ///< of the noise; equal seeds give equal runs
    double stamp_Hz; ///< rate of the free-running 32-bit stamp

    /// Also integrate energies and mean terminal voltages (plant_truth_t); the motion is the same.
    bool keeps_accounts;
} plant_config_t;

/// Inputs of the firmware at t_k for one set; bus, temperature and stamp are the same for both.
typedef struct {
    uint16_t i[PLANT_PHASES]; ///< out of the inverter into the motor: above half scale
    uint16_t
        link[PLANT_LINKS]; ///< shunt in the DC link; into the bridge: above half scale; 0: none
    uint16_t v_bus;
    uint16_t temperature;
    bool trip;      ///< hardware trip; see plant_set_trip
    uint32_t stamp; ///< free-running, wraps
} plant_counts_t;

/// The motor of Jiang et al., Energies 2022, 15, 1943, Table 3, at 200 V, 5 kHz and 4 us dead time,
/// switching level, at rest, no load. The paper gives neither on-state drops, harmonics nor
/// saturation: those are zero here. Keeps accounts. The ADC (12 bit, +-25 A, 0..409.5 V) and a timer of
/// 16800 steps belong to a plausible board, also not from the paper.
plant_config_t plant_config_jiang2022(void);

#endif
