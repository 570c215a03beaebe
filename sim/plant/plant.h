/// A motor, its shaft, its inverter and its current sensors, against which the firmware is tested.
///
/// Independent of the library under test: includes none of its headers and computes in double.
///
///     plant_t plant;
///     const plant_config_t config = plant_config_jiang2022();
///     const char *error = plant_init(&plant, &config);    NULL if all is well
///     for (;;) {
///         plant_sample(&plant, &counts, &truth);           at t_k
///         plant_write(&plant, duty, gates);                from the same interrupt
///         plant_advance(&plant);                           to t_k+1
///     }
///
/// Timing. t_k starts PWM period k and lies in the middle of its zero vector (all low sides on).
/// Duties written at t_k are shadowed and act in [t_k+1, t_k+2). Gates off acts already in [t_k, t_k+1), as a
/// hardware output-enable does; gates on acts with its duties at t_k+1. Without a
/// new write the last one stays in force.
///
/// Six phases (plant_config_t.sets = 2): plant_sample() fills an array of two counts, and
/// plant_write_set() writes one set; everything else is the same.
///
/// Conventions. Amplitude-invariant transforms; theta on the magnet's north pole, 0 on phase a;
/// current positive into the motor; EMF e = j w psi_a exp(j theta); motor torque positive in the
/// direction of positive speed, load torque against it.
#ifndef PLANT_H
#define PLANT_H

#include "plant/adc.h"
#include "plant/config.h"
#include "plant/inverter.h"
#include "plant/motor.h"

/// Energy balance since plant_init(), integrated with the states if the configuration keeps accounts, otherwise
/// NaN:
///     bus = copper + inverter + friction + load + (field + kinetic) - (the same at the start)
typedef struct {
    double bus_J;      ///< out of the DC source; negative when it is charged
    double copper_J;   ///< in the windings
    double inverter_J; ///< on-state losses (there are no switching losses)
    double shaft_J;    ///< converted from electrical to mechanical
    double friction_J; ///< viscous
    double load_J;     ///< into the load or the dynamometer
    double field_J;    ///< held now; the magnet's own share left out
    double kinetic_J;  ///< held now
    double chopper_J;  ///< in the brake resistor, out of the capacitor: no part of the sum
} plant_energy_t;

/// The true values at t_k, without sensor errors.
typedef struct {
    double t_s;
    double theta_e_rad; ///< (-pi, pi]
    double omega_e_rad_s, omega_m_rad_s;
    double i_abc_A[PLANT_LEGS]; ///< of set 2 from [3] on
    double id_A, iq_A;
    double i_alpha_A, i_beta_A;
    double i_x_A, i_y_A;        ///< two sets; 0 with one
    double e_alpha_V, e_beta_V; ///< j w psi_a exp(j theta), psi_a = psi + (Ld - Lq) id, + harmonics
    double e_x_V, e_y_V;        ///< two sets: 5th and 7th harmonic
    double torque_Nm;           ///< of the motor
    /// Mean terminal voltage over [t_k-1, t_k); NaN if the plant keeps no accounts.
    double u_alpha_V, u_beta_V;
    double u_x_V, u_y_V;
    bool open[PLANT_LEGS]; ///< the phase is broken
    plant_energy_t energy;
} plant_truth_t;

/// Visible for static allocation; written only by plant*.c. A copy is an independent plant.
typedef struct {
    plant_motor_t motor;
    plant_inverter_t inverter;
    plant_adc_t adc;
    double period_s, sample_offset_s, stamp_Hz, temperature_degC;
    uint64_t periods; ///< k
    int sets;
    bool trip[PLANT_SETS];
    plant_gates_t gates[PLANT_SETS],
        next_gates[PLANT_SETS];                     ///< in the present period, in the next one
    double duty[PLANT_LEGS], next_duty[PLANT_LEGS]; ///< of the first half of a period
    double fall[PLANT_LEGS], next_fall[PLANT_LEGS]; ///< of its second half
    double link_at[PLANT_LINKS], next_link_at[PLANT_LINKS];
    double link_A[PLANT_LINKS]; ///< sampled in the period that has ended
    double now_s;               ///< within the present period
    int events_left;
    plant_planes_t u_Vs; ///< over the present period, then over the last one
    double i_early_A[PLANT_LEGS];
    plant_energy_t energy;
    double bus_C_F, source_V;
    double chopper_R_Ohm;
    double chopper, next_chopper; ///< duty in the present period, in the next one
    double drawn_J;               ///< energy.bus_J at the start of the period
    bool watches_peak;
    double peak_A;
} plant_t;

/// NULL, or the reason of a refusal in words; then the object is unchanged. Starts with gates off and no current.
const char *plant_init(plant_t *self, const plant_config_t *config);

/// Reads ADC and truth at t_k; either may be NULL. Each conversion draws fresh noise. `counts`
/// is one per set.
void plant_sample(plant_t *self, plant_counts_t *counts, plant_truth_t *truth);

/// Duties 0..1 (outside counts as the nearer end, NaN as 0) of the high sides, and what may switch. With the
/// low sides alone the inverter switches even at the averaged level.
/// plant_write() means the first set.
void plant_write(plant_t *self, const double duty[PLANT_PHASES], plant_gates_t gates);
void plant_write_set(plant_t *self, int set, const double duty[PLANT_PHASES], plant_gates_t gates);

/// The same with a duty for each half of the period: high from (1 - rise)/2 to (1 + fall)/2 of it.
void plant_write_halves(plant_t *self, const double rise[PLANT_PHASES],
                        const double fall[PLANT_PHASES], plant_gates_t gates);

/// On-time of the brake chopper's switch, 0..1, from the next period on.
void plant_write_chopper(plant_t *self, double duty);

/// Present bus voltage.
double plant_bus_V(const plant_t *self);

/// Sampling instants of the shunt in the DC link, as shares of the period, in order; from the next period on.
/// The samples (set 1) are in plant_counts_t.link at the end of that period.
void plant_set_link_samples(plant_t *self, const double at[PLANT_LINKS]);

/// Simulates one PWM period, t_k to t_k+1.
void plant_advance(plant_t *self);

/// From now on the largest phase current is recorded, also between the samples: at every edge, and at each
/// change of conduction.
void plant_watch_peak(plant_t *self);

/// The largest phase current since then.
double plant_peak_A(const plant_t *self);

/// Passive load: the sign does not matter. Otherwise positive brakes positive speed.
void plant_set_load(plant_t *self, double load_Nm);

/// Sets the kind of load from now on.
void plant_set_passive(plant_t *self, bool load_is_passive);

/// From now on the shaft turns at this speed for any torque, as on a stiff dynamometer.
void plant_set_speed(plant_t *self, double omega_m_rad_s);

/// Ends plant_set_speed(): the shaft continues freely from its present speed.
void plant_release_speed(plant_t *self);

void plant_set_bus(plant_t *self, double v_bus_V);

void plant_set_temperature(plant_t *self, double temperature_degC);

/// The hardware's trip input: while true all gates are off, from the present t_k on, and the firmware reads it.
/// When it ends, the last write is in force again.
void plant_set_trip(plant_t *self, bool trip);
/// The same for one set.
void plant_set_trip_of(plant_t *self, int set, bool trip);

/// One switch of a leg no longer turns on, or is shorted: see plant_inverter_fail().
void plant_fail_switch(plant_t *self, int leg, bool high, bool shorted);
/// The magnets have this flux from now on.
void plant_set_flux(plant_t *self, double psi_Wb);
/// The last write acts from now on, as with a register without a shadow.
void plant_write_through(plant_t *self);

/// A wire breaks: the phase of this leg (0..2 of set 1, 3..5 of set 2) carries no current from
/// the next zero of its current on.
void plant_open_phase(plant_t *self, int leg);

#endif
