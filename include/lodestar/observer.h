/// The linear extended state observers of both papers, as filters of the dead-beat EMF m[k].
///
/// On the R-Lq circuit and with exact discretisation, each of them reduces to a filter from m to the estimate e
/// (docs/theory/emf.md). `observers.def` lists them.
#ifndef LODESTAR_OBSERVER_H
#define LODESTAR_OBSERVER_H

#include "lodestar/config.h"
#include "lodestar/frames.h"
#include "lodestar/options.h"
#include "lodestar/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Kinds of observers: LODE_EMF_C_LESO, LODE_EMF_GI_LESO and so on, described in `observers.def`.
typedef enum {
#define LODE_OBSERVER(ID, id, name, STEP, vectors, numbers) LODE_EMF_##ID,
#include "lodestar/observers.def"
#undef LODE_OBSERVER
    LODE_EMF_KINDS ///< number of kinds
} lode_emf_kind_t;

/// Kind of the observer, and the parameters of all kinds.
typedef struct {
    lode_emf_kind_t kind;
// float w0_rad_s, gi_kappa and so on: see `observers.def`.
#define LODE_OBSERVER_FIELD(name) float name;
#include "lodestar/observers.def"
#undef LODE_OBSERVER_FIELD
} lode_observer_config_t;

// LODE_IF_BUILT_IN(ID, code): `code`, or nothing in a build with -DLODE_WITHOUT_<ID>. That option then has the value 1,
// and LODE_OPTION_1 moves LODE_DROP to second place.
#define LODE_IF_BUILT_IN(ID, ...) LODE_CHOOSE(LODE_WITHOUT_##ID)(__VA_ARGS__)
#define LODE_CHOOSE(option) LODE_CHOOSE_BY(option)
#define LODE_CHOOSE_BY(option) LODE_SECOND(LODE_OPTION_##option, LODE_KEEP, LODE_KEEP)
#define LODE_SECOND(...) LODE_SECOND_OF(__VA_ARGS__)
#define LODE_SECOND_OF(first, second, ...) second
#define LODE_OPTION_1 1, LODE_DROP
#define LODE_KEEP(...) __VA_ARGS__
#define LODE_DROP(...)

// As large as the largest observer that is built in: all code that includes this must be built with the same ones.
typedef union {
#define LODE_OBSERVER(ID, id, name, STEP, vectors, numbers)                                        \
    LODE_IF_BUILT_IN(ID, char id##_has[vectors];)
#include "lodestar/observers.def"
#undef LODE_OBSERVER
} lode_observer_vectors_t;

typedef union {
#define LODE_OBSERVER(ID, id, name, STEP, vectors, numbers)                                        \
    LODE_IF_BUILT_IN(ID, char id##_has[numbers];)
#include "lodestar/observers.def"
#undef LODE_OBSERVER
} lode_observer_numbers_t;

/// Parameters derived for the chosen observer; its source file names the elements of `own`.
typedef struct {
    uint32_t kind; ///< lode_emf_kind_t
    float own[sizeof(lode_observer_numbers_t)];
} lode_observer_tuning_t;

/// State of the chosen observer; its source file names the elements of `own`.
typedef struct {
    lode_ab_t e_V; ///< estimated EMF, stator axes
    lode_ab_t own[sizeof(lode_observer_vectors_t)];
} lode_observer_t;

/// Fills every zero field that has a default, including those of the other observers.
void lode_observer_design(lode_observer_config_t *config, float omega_rated_rad_s,
                          float sigma_rad_s, float ts_s);

/// Checks a completed configuration and derives the tuning. `notch_rad_s`: lode_pll_notch_rad_s() of the PLL that
/// follows; for notches of the observer's own. 0: none follows.
lode_status_t lode_observer_tune(lode_observer_tuning_t *tuning,
                                 const lode_observer_config_t *config, float notch_rad_s,
                                 float ts_s);

/// LODE_OK if the observer is stable together with a PLL of the given bandwidth.
lode_status_t lode_observer_check_pll(const lode_observer_config_t *config, float sigma_rad_s,
                                      bool third_order);

void lode_observer_reset(lode_observer_t *self);

/// Clears the states that decay slowly, such as the band-pass of GI. The estimate stays.
void lode_observer_settle(lode_observer_t *self, const lode_observer_tuning_t *tuning);

/// Sets the state that results after a long time in which the estimate, now `e_V`, has turned by `step_rad` per
/// period.
void lode_observer_begin(lode_observer_t *self, const lode_observer_tuning_t *tuning, lode_ab_t e_V,
                         float step_rad);

/// Exact phase lag of e against m in steady rotation at the electrical speed `omega_rad_s`, rad; odd in omega. For
/// init and host.
float lode_observer_lag_rad(const lode_observer_config_t *config, float ts_s, float omega_rad_s);

/// Droop of |e/m| with the electrical speed w, s^2: |e/m| is close to 1/(1 + droop w^2).
float lode_observer_droop_s2(const lode_observer_config_t *config);

/// Delay, s, with which speed control is designed: that of the observer within the loop of the PLL (P32).
float lode_observer_delay_s(const lode_observer_config_t *config);

#ifdef __cplusplus
}
#endif

#endif
