/// Position from signal injection, for zero and low speed: a square wave of voltage along the estimated d
/// axis, whose current shows where the axis of least inductance is. docs/theory/injection.md.
///
/// Needs a rotor whose q axis has the larger inductance, at load too. The tone, at half the call rate, is audible up to
/// about 30 000 calls a second. Off by default; LODE_WITHOUT_HFI leaves it out of a build, which then refuses it.
#ifndef LODESTAR_HFI_H
#define LODESTAR_HFI_H

#include "lodestar/config.h"
#include "lodestar/inverter.h"
#include "lodestar/motor.h"
#include "lodestar/pll.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    LODE_HFI_OFF,     ///< nothing is injected
    LODE_HFI_ON,      ///< at low speed; refused where the machine does not allow it
    LODE_HFI_AUTO = 3 ///< on where the machine allows it, else off; 2 (LODE_OFF) is refused
} lode_hfi_mode_t;

typedef struct {
    lode_hfi_mode_t mode;
    float
        V_h_V; ///< amplitude of the square wave; 0: the largest that noise, dead time and ripple ask for
    float w1_rad_s; ///< ELECTRICAL speed up to which injection alone gives the position; 0: 0.65 w2
    float
        w2_rad_s; ///< from which the EMF alone does, and nothing is injected; 0: by dead time and psi
    float sigma_rad_s; ///< bandwidth of the PLL while injecting; 0: as at rated speed
    /// angle by which i_q turns the axis of least inductance (cross-saturation), rad/A; 0: none
    float k_x_rad_A;
    /// DIFFERENTIAL q-axis inductance, d(psi_q)/d(i_q), at i_max; 0: from Lq_H and references.Lq_fall
    float Lq_i_max_H;
    /// POSITIVE d current while injecting, which saturates the d axis and so makes the rotor more salient; fades
    /// from w2 to 2 w2. It takes the place of the references' negative one. 0: 0.3 i_max where Lq_i_max_H is
    /// below 1.5 Ld_H, else none; LODE_NONE: none
    float id_A;
    float
        noise_A; ///< rms noise of one component of the current vector; 0: 1.6 counts, six phases 1.13
    /// injects up to where an error of Lq shows, for learn.h: raises the defaults of w1 and w2; auto: off
    lode_choice_t learn;
    /// signs by pairs in a random order, so that no tone stands out, and no more amplitude by default than noise
    /// and dead time ask for; auto: off
    lode_choice_t silent;
} lode_hfi_config_t;

/// Inputs of the design.
typedef struct {
    const lode_motor_t *motor;
    const lode_inverter_config_t *inverter;
    float ts_s;
    float circle_V;    ///< radius of current control's voltage circle
    float count_A;     ///< one count of the current's ADC
    float sigma_rad_s; ///< of the PLL at rated speed
    float omega_max_rad_s;
    float Lq_fall;    ///< of the references
    bool active_flux; ///< the EMF's prediction has Ld - Lq in it, by which injection sees the rotor
} lode_hfi_system_t;

typedef struct {
    float V_h_V;
    float omega_high; ///< w2
    float inv_span;   ///< 1/(w2 - w1)
    float inv_full;   ///< 1/H0, by which the regressor moves in a period on the true axis (H5)
    float least_V2;   ///< square of the least such move that is divided by (H4)
    float k_x;        ///< rad/A
    float iq_weight;  ///< of a new i_q in the one that turns the axis, once in LODE_SLOW_PERIODS
    float
        find_gain; ///< of the angle, while it is looked for at rest (H14); the PLL's gains follow from it
    uint_least16_t
        find_rounds; ///< LODE_SLOW_PERIODS each; 0: nothing is injected. Half with either sign
    uint_least16_t silent; ///< 0 or 1
} lode_hfi_tuning_t;

/// What a start at rest is doing.
typedef enum {
    LODE_HFI_FIND,     ///< the axis, from any angle
    LODE_HFI_NORTH,    ///< current along it,
    LODE_HFI_SOUTH,    ///< and against it
    LODE_HFI_PUSH,     ///< the iron shows no difference: current across it, until the rotor moves
    LODE_HFI_RIGHT,    ///< done: the magnet's north is where the angle is,
    LODE_HFI_WRONG,    ///< or opposite
    LODE_HFI_UNDECIDED ///< nothing shows it
} lode_hfi_step_t;

/// Responses to the wave, in a start at rest.
typedef struct {
    float along_V;         ///< sum of swing_V with current along the axis
    float against_V;       ///< and against it
    float squares_V2;      ///< of both
    uint_least16_t rounds; ///< in this step of the start
} lode_hfi_start_t;

/// LODE_HFI_PUSH.
typedef struct {
    lode_sincos_t from;    ///< the angle before
    uint_least16_t rounds; ///< since
} lode_hfi_push_t;

/// The last wave had the negative sign; it was the first of its pair; shift register, 0: the signs alternate.
#define LODE_HFI_NEGATIVE 0x8000u
#define LODE_HFI_FIRST 0x4000u
#define LODE_HFI_RANDOM 0x3FFFu

/// What injection keeps from period to period; that of the estimator. Of a period that does not inject the first
/// members alone, which lode_estimator_alone_t has too.
typedef struct {
    bool active;          ///< injecting
    uint_least8_t step;   ///< lode_hfi_step_t of a start
    uint_least16_t signs; ///< of the wave: LODE_HFI_NEGATIVE, _FIRST, _RANDOM
    float
        reserve_V; ///< bus voltage that current control leaves to the wave; 0: nothing is injected
    float weight;  ///< of its position error beside the EMF's (H11)
    float error;   ///< its position error at t_k, rad (H3), not limited
    float q_V;     ///< dead-beat EMF across the axis (H1)
    float h_V;     ///< regressor (H1)
    float sum_V;   ///< magnitudes of H, by which it moves in a period, since the last look
    float swing_V; ///< their mean in the last round
    float off_rad; ///< mean magnitude of the error
    float axis;    ///< tangent of the angle to it from the estimated d axis, by cross-saturation
    lode_dq_t i_A; ///< current in the rotor's frame at t_k, ripple included
    union {
        float iq_A;             ///< low-passed, when the start is over
        lode_hfi_start_t start; ///< before
        lode_hfi_push_t push;   ///< at its end
    } of;
} lode_hfi_t;

/// Saliency below which nothing is injected: Lq'(i_max)/Ld'.
#define LODE_HFI_SALIENCY_MIN 1.15f

/// Fills every zero field that has a default, and settles LODE_HFI_AUTO.
void lode_hfi_design(lode_hfi_config_t *config, const lode_hfi_system_t *system);

lode_status_t lode_hfi_tune(lode_hfi_tuning_t *tuning, const lode_hfi_config_t *config,
                            const lode_hfi_system_t *system);

#ifdef __cplusplus
}
#endif

#endif
