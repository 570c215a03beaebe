/// The linear extended state observers of both papers as filters of the dead-beat EMF m[k].
///
/// Written on the R-Lq circuit and discretised exactly, every one of them reduces to a filter from
/// m to the estimate e (docs/theory/emf.md). `observers.def` names them.
#ifndef LODESTAR_OBSERVER_H
#define LODESTAR_OBSERVER_H

#include "lodestar/config.h"
#include "lodestar/frames.h"
#include "lodestar/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/// LODE_EMF_C_LESO, LODE_EMF_GI_LESO and so on: `observers.def` says what each is.
typedef enum {
#define LODE_OBSERVER(ID, id, name, STEP, vectors, numbers) LODE_EMF_##ID,
#include "lodestar/observers.def"
#undef LODE_OBSERVER
    LODE_EMF_KINDS ///< how many there are
} lode_emf_kind_t;

typedef struct {
    lode_emf_kind_t kind;
// float w0_rad_s, gi_kappa and so on: `observers.def`.
#define LODE_OBSERVER_FIELD(name) float name;
#include "lodestar/observers.def"
#undef LODE_OBSERVER_FIELD
} lode_observer_config_t;

// LODE_IF_BUILT_IN(ID, code): `code`, or nothing where the build has -DLODE_WITHOUT_<ID>. The option is 1
// then, and LODE_OPTION_1 puts LODE_DROP in second place.
#define LODE_IF_BUILT_IN(ID, ...) LODE_CHOOSE(LODE_WITHOUT_##ID)(__VA_ARGS__)
#define LODE_CHOOSE(option) LODE_CHOOSE_BY(option)
#define LODE_CHOOSE_BY(option) LODE_SECOND(LODE_OPTION_##option, LODE_KEEP, LODE_KEEP)
#define LODE_SECOND(...) LODE_SECOND_OF(__VA_ARGS__)
#define LODE_SECOND_OF(first, second, ...) second
#define LODE_OPTION_1 1, LODE_DROP
#define LODE_KEEP(...) __VA_ARGS__
#define LODE_DROP(...)

// As large as the largest that is built in: whoever includes this must leave out the same ones.
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

/// The file of each observer names what is in `own`.
typedef struct {
    uint32_t kind; ///< lode_emf_kind_t
    float own[sizeof(lode_observer_numbers_t)];
} lode_observer_tuning_t;

typedef struct {
    lode_ab_t e_V; ///< the estimate
    lode_ab_t own[sizeof(lode_observer_vectors_t)];
} lode_observer_t;

/// Fills every zero field that has a default, of the other observers too.
void lode_observer_design(lode_observer_config_t *config, float omega_rated_rad_s,
                          float sigma_rad_s, float ts_s);

lode_status_t lode_observer_tune(lode_observer_tuning_t *tuning,
                                 const lode_observer_config_t *config, float omega_rated_rad_s,
                                 float ts_s);

/// LODE_OK where the observer is stable with a PLL of the given bandwidth after it.
lode_status_t lode_observer_check_pll(const lode_observer_config_t *config, float sigma_rad_s,
                                      bool third_order);

void lode_observer_reset(lode_observer_t *self);

/// Empties the states that forget slowly, as GI's band-pass; the estimate stays.
void lode_observer_settle(lode_observer_t *self, const lode_observer_tuning_t *tuning);

/// As after a long time in which the estimate, `e_V` now, has turned by `step_rad` per period.
void lode_observer_begin(lode_observer_t *self, const lode_observer_tuning_t *tuning, lode_ab_t e_V,
                         float step_rad);

/// Exact phase lag of e against m in steady rotation at `omega_rad_s`, rad, odd. For init and host.
float lode_observer_lag_rad(const lode_observer_config_t *config, float ts_s, float omega_rad_s);

/// How |e/m| falls with speed: it is near 1/(1 + droop w^2), s^2.
float lode_observer_droop_s2(const lode_observer_config_t *config);

#ifdef __cplusplus
}
#endif

#endif
