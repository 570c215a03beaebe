/// Position from signal injection, for zero and low speed: a square wave of voltage along the estimated d axis. The current
/// that it drives shows the axis of least inductance. docs/theory/injection.md.
///
/// Requires a rotor whose q-axis inductance is the larger one, under load too. The tone has half the rate of the step and is
/// audible up to about 30 000 steps per second. By default only for reluctance machines, see LODE_HFI_DEFAULT.
/// LODE_WITHOUT_HFI leaves it out of a build, which refuses it.
#ifndef LODESTAR_HFI_H
#define LODESTAR_HFI_H

#include "lodestar/config.h"
#include "lodestar/inverter.h"
#include "lodestar/motor.h"
#include "lodestar/pll.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Use of injection. ON and OFF have the values of LODE_ON and LODE_OFF.
typedef enum {
    LODE_HFI_DEFAULT, ///< as AUTO if the current vector of a start has too little torque (S54), otherwise off
    LODE_HFI_ON,  ///< at low speed; refused if the machine does not allow it
    LODE_HFI_OFF, ///< nothing is injected
    LODE_HFI_AUTO ///< on if machine and build allow it, otherwise off
} lode_hfi_mode_t;

/// Configuration of injection. Speeds are ELECTRICAL. A field that is 0 gets its default from lode_hfi_design().
typedef struct {
    lode_hfi_mode_t mode;
    /// amplitude of the square wave; 0: the largest of what noise, dead time and ripple require
    float V_h_V;
    float w1_rad_s; ///< speed up to which injection alone gives the position; 0: 0.65 w2
    /// speed from which the EMF alone gives the position, without injection; 0: from dead time and psi (H10)
    float w2_rad_s;
    float sigma_rad_s; ///< bandwidth of the PLL during injection; 0: as at rated speed
    /// angle by which i_q turns the axis of least inductance (cross-saturation, H6), rad/A; 0: none
    float k_x_rad_A;
    /// DIFFERENTIAL q-axis inductance d(psi_q)/d(i_q) at i_max; 0: from Lq_H and references.Lq_fall
    float Lq_i_max_H;
    /// POSITIVE d current during injection. It saturates the d axis, which increases the saliency, and fades out
    /// from w2 to 2 w2. It replaces the negative id bias of the references. 0: 0.3 i_max if Lq_i_max_H is below 1.5
    /// Ld_H, otherwise none; LODE_NONE: none
    float id_A;
    /// rms noise of one component of the current vector; 0: 1.6 ADC counts, with six phases 1.13
    float noise_A;
    /// inject up to the speed at which an error of Lq can be seen, for learn.h: raises the defaults of w1 and w2;
    /// auto: off
    lode_choice_t learn;
    /// random order of the signs in pairs, so that there is no tone; by default the amplitude is then only what
    /// noise and dead time require; auto: off
    lode_choice_t silent;
} lode_hfi_config_t;

/// What the design needs to know about the drive.
typedef struct {
    const lode_motor_t *motor;
    const lode_inverter_config_t *inverter;
    float ts_s;
    float circle_V;        ///< radius of the voltage circle of current control
    float count_A;         ///< one ADC count of a phase current
    float sigma_rad_s;     ///< bandwidth of the PLL at rated speed
    float omega_max_rad_s; ///< estimator.omega_max_rad_s
    float Lq_fall;         ///< references.Lq_fall
    /// estimator.active_flux is on: the EMF model then includes Ld - Lq, which injection needs
    bool active_flux;
} lode_hfi_system_t;

/// All that is derived from the configuration.
typedef struct {
    float V_h_V;
    float omega_high; ///< w2
    float inv_span;   ///< 1/(w2 - w1)
    float inv_full;   ///< 1/H0; H0: change of the regressor per period on the true axis (H5)
    float least_V2;   ///< square of the least such change that is used as a divisor (H4)
    float k_x;        ///< cross-saturation, rad/A
    float iq_weight;  ///< weight of a new i_q in the low-pass for (H6), once in LODE_SLOW_PERIODS
    /// gain of the angle in the search at rest (H14); the gains of the PLL follow from it
    float find_gain;
    /// length of a search step, LODE_SLOW_PERIODS each; half of it per polarity; 0: no injection
    uint_least16_t find_rounds;
    uint_least16_t silent; ///< 1: random signs
} lode_hfi_tuning_t;

/// Step of a start at rest.
typedef enum {
    LODE_HFI_FIND,  ///< searches for the axis, from any angle
    LODE_HFI_NORTH, ///< polarity: current along the axis
    LODE_HFI_SOUTH, ///< polarity: current against the axis
    LODE_HFI_PUSH, ///< the iron shows no polarity: current across the axis until the rotor moves (H25)
    LODE_HFI_RIGHT,    ///< done: the estimated angle points to the magnet's north
    LODE_HFI_WRONG,    ///< done: it points to the south
    LODE_HFI_UNDECIDED ///< nothing shows the polarity
} lode_hfi_step_t;

/// Responses to the wave in a start at rest (H15), (H21).
typedef struct {
    float along_V;         ///< sum of swing_V with current along the axis
    float against_V;       ///< the same with current against it
    float squares_V2;      ///< sum of the squares of both
    uint_least16_t rounds; ///< rounds in the present step
} lode_hfi_start_t;

/// State of LODE_HFI_PUSH.
typedef struct {
    lode_sincos_t from;    ///< angle before the push
    uint_least16_t rounds; ///< rounds since then
} lode_hfi_push_t;

/// Bits of lode_hfi_t.signs: the last wave was negative; it was the first of its pair; shift register (0: the signs
/// alternate).
#define LODE_HFI_NEGATIVE 0x8000u
#define LODE_HFI_FIRST 0x4000u
#define LODE_HFI_RANDOM 0x3FFFu

/// State of injection, a part of the estimator's. The first members are valid without injection too;
/// lode_estimator_alone_t has them at the same place.
typedef struct {
    bool active;          ///< injection is on
    uint_least8_t step;   ///< lode_hfi_step_t of a start
    uint_least16_t signs; ///< LODE_HFI_NEGATIVE, _FIRST, _RANDOM
    /// bus voltage that current control leaves to the wave; 0: no injection
    float reserve_V;
    float weight;  ///< weight of the position error from injection; the EMF has the rest (H11)
    float error;   ///< position error at t_k from injection, rad (H3), not limited
    float q_V;     ///< dead-beat EMF across the axis (H1)
    float h_V;     ///< regressor h (H1)
    float sum_V;   ///< sum of the changes of h per period, as magnitudes, in the present round
    float swing_V; ///< their mean in the last round
    float off_rad; ///< mean magnitude of the position error
    float axis;    ///< tangent of the angle from the estimated d axis to the injection axis (H6)
    float emf_V2;  ///< START: square of the observed EMF, low-pass filtered
    lode_dq_t i_A; ///< current at t_k in the rotor's frame, with ripple
    union {
        float iq_A;             ///< after the start: low-pass filtered i_q
        lode_hfi_start_t start; ///< during the start
        lode_hfi_push_t push;   ///< at its end, in LODE_HFI_PUSH
    } of;
    bool shown;          ///< the currents have shown the wave, with the axis found (H29)
    uint_least8_t early; ///< rounds until the currents can show a whole round of the wave
    uint_least8_t weak;  ///< score of the weak rounds in a row (H29)
} lode_hfi_t;

/// Saliency Lq'(i_max)/Ld' below which injection is refused (H0).
#define LODE_HFI_SALIENCY_MIN 1.15f

/// Fills every zero field that has a default, and replaces LODE_HFI_DEFAULT and LODE_HFI_AUTO by on or off.
void lode_hfi_design(lode_hfi_config_t *config, const lode_hfi_system_t *system);

/// True if a completed configuration lacks injection although the start would need it (S54), because the machine does
/// not allow it.
bool lode_hfi_is_missed(const lode_hfi_config_t *config, const lode_hfi_system_t *system);

/// Checks a completed configuration and derives the tuning.
lode_status_t lode_hfi_tune(lode_hfi_tuning_t *tuning, const lode_hfi_config_t *config,
                            const lode_hfi_system_t *system);

#ifdef __cplusplus
}
#endif

#endif
