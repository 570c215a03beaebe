#define LODE_OBSERVER_INIT
#include "observer_inline.h"

void lode_observer_design(lode_observer_config_t *config, float omega_rated_rad_s,
                          float sigma_rad_s, float ts_s) {
    // The chosen observer first: several observers share fields, with different defaults.
#define LODE_OBSERVER(ID, id, name, STEP, vectors, numbers)                                        \
    LODE_IF_BUILT_IN(                                                                              \
        ID, if (config->kind == LODE_EMF_##ID) {                                                   \
            id##_design(config, omega_rated_rad_s, sigma_rad_s, ts_s);                             \
        })
#include "lodestar/observers.def"
#undef LODE_OBSERVER
#define LODE_OBSERVER(ID, id, name, STEP, vectors, numbers)                                        \
    LODE_IF_BUILT_IN(ID, id##_design(config, omega_rated_rad_s, sigma_rad_s, ts_s);)
#include "lodestar/observers.def"
#undef LODE_OBSERVER
}

static lode_status_t first_error(lode_status_t a, lode_status_t b) {
    return a != LODE_OK ? a : b;
}

// Checks the fields of all observers of this build, not only those of the chosen one.
static lode_status_t check(const lode_observer_config_t *config, float ts_s) {
    lode_status_t status = LODE_OK;
#define LODE_OBSERVER(ID, id, name, STEP, vectors, numbers)                                        \
    LODE_IF_BUILT_IN(ID, status = first_error(status, id##_check(config, ts_s));)
#include "lodestar/observers.def"
#undef LODE_OBSERVER
    return status;
}

// False where the observer is not built in.
static bool tune_own(float *own, const lode_observer_config_t *config, float notch_rad_s,
                     float ts_s) {
#define LODE_OBSERVER(ID, id, name, STEP, vectors, numbers)                                        \
    LODE_IF_BUILT_IN(                                                                              \
        ID, if (config->kind == LODE_EMF_##ID) {                                                   \
            id##_tune(own, config, notch_rad_s, ts_s);                                             \
            return true;                                                                           \
        })
#include "lodestar/observers.def"
#undef LODE_OBSERVER
    return false;
}

lode_status_t lode_observer_tune(lode_observer_tuning_t *tuning,
                                 const lode_observer_config_t *config, float notch_rad_s,
                                 float ts_s) {
    lode_observer_tuning_t tuned = {.kind = (uint32_t)config->kind};
    if (!tune_own(tuned.own, config, notch_rad_s, ts_s)) {
        return LODE_ERROR_EMF_KIND;
    }
    const lode_status_t status = check(config, ts_s);
    if (status == LODE_OK) {
        *tuning = tuned;
    }
    return status;
}

lode_status_t lode_observer_check_pll(const lode_observer_config_t *config, float sigma_rad_s,
                                      bool third_order) {
#define LODE_OBSERVER(ID, id, name, STEP, vectors, numbers)                                        \
    LODE_IF_BUILT_IN(                                                                              \
        ID, if (config->kind == LODE_EMF_##ID) {                                                   \
            return id##_check_pll(config, sigma_rad_s, third_order);                               \
        })
#include "lodestar/observers.def"
#undef LODE_OBSERVER
    return LODE_ERROR_EMF_KIND;
}

void lode_observer_reset(lode_observer_t *self) {
    const lode_observer_t none = {.e_V = {0.0f, 0.0f}};
    *self = none;
}

void lode_observer_settle(lode_observer_t *self, const lode_observer_tuning_t *tuning) {
#define LODE_OBSERVER(ID, id, name, STEP, vectors, numbers)                                        \
    LODE_IF_BUILT_IN(                                                                              \
        ID, if (tuning->kind == (uint32_t)LODE_EMF_##ID) { id##_settle(self); })
#include "lodestar/observers.def"
#undef LODE_OBSERVER
}

void lode_observer_begin(lode_observer_t *self, const lode_observer_tuning_t *tuning, lode_ab_t e_V,
                         float step_rad) {
    const lode_sincos_t back = lode_sincos(-step_rad);
    lode_observer_reset(self);
    self->e_V = e_V;
    (void)back; // the observers that need it may not be built in
#define LODE_OBSERVER(ID, id, name, STEP, vectors, numbers)                                        \
    LODE_IF_BUILT_IN(                                                                              \
        ID, if (tuning->kind == (uint32_t)LODE_EMF_##ID) { id##_begin(self, tuning->own, back); })
#include "lodestar/observers.def"
#undef LODE_OBSERVER
}

LODE_RAMFUNC void lode_observer_step_called(lode_observer_t *self,
                                            const lode_observer_tuning_t *tuning, lode_ab_t m_V,
                                            lode_sincos_t step_angle, float omega_rad_s) {
    (void)self, (void)tuning, (void)m_V, (void)step_angle,
        (void)omega_rad_s; // such observers may not be built in
#define STEP_FIXED(ID, id)
#define STEP_INLINE(ID, id)
#define STEP_CALLED(ID, id)                                                                        \
    if (tuning->kind == (uint32_t)LODE_EMF_##ID) {                                                 \
        (void)id##_step(self, tuning, m_V, step_angle, omega_rad_s);                               \
    }
#define LODE_OBSERVER(ID, id, name, STEP, vectors, numbers)                                        \
    LODE_IF_BUILT_IN(ID, STEP_##STEP(ID, id))
#include "lodestar/observers.def"
#undef LODE_OBSERVER
#undef STEP_CALLED
#undef STEP_INLINE
#undef STEP_FIXED
}

float lode_observer_lag_rad(const lode_observer_config_t *config, float ts_s, float omega_rad_s) {
#define LODE_OBSERVER(ID, id, name, STEP, vectors, numbers)                                        \
    LODE_IF_BUILT_IN(                                                                              \
        ID,                                                                                        \
        if (config->kind == LODE_EMF_##ID) { return id##_lag_rad(config, ts_s, omega_rad_s); })
#include "lodestar/observers.def"
#undef LODE_OBSERVER
    return 0.0f;
}

float lode_observer_droop_s2(const lode_observer_config_t *config) {
#define LODE_OBSERVER(ID, id, name, STEP, vectors, numbers)                                        \
    LODE_IF_BUILT_IN(                                                                              \
        ID, if (config->kind == LODE_EMF_##ID) { return id##_droop_s2(config); })
#include "lodestar/observers.def"
#undef LODE_OBSERVER
    return 0.0f;
}

float lode_observer_delay_s(const lode_observer_config_t *config) {
#define LODE_OBSERVER(ID, id, name, STEP, vectors, numbers)                                        \
    LODE_IF_BUILT_IN(                                                                              \
        ID, if (config->kind == LODE_EMF_##ID) { return id##_delay_s(config); })
#include "lodestar/observers.def"
#undef LODE_OBSERVER
    return 0.0f;
}
