// The EMF observer of the step: one dispatch, without a function pointer.
#ifndef LODESTAR_OBSERVER_INLINE_H
#define LODESTAR_OBSERVER_INLINE_H

#include "lodestar/observer.h"

#define LODE_OBSERVER_CODE
#include "lodestar/observers.def"
#undef LODE_OBSERVER_CODE

/// Step of an observer whose STEP in the table is CALLED.
void lode_observer_step_called(lode_observer_t *self, const lode_observer_tuning_t *tuning,
                               lode_ab_t m_V, lode_sincos_t step_angle, float omega_rad_s);

// False for an observer that does not need step angle and speed; a constant in a build with only such observers.
LODE_INLINE bool lode_observer_rotates(const lode_observer_tuning_t *tuning) {
#define ROTATES_FIXED(ID)
#define ROTATES_INLINE(ID) ROTATING_##ID,
#define ROTATES_CALLED(ID) ROTATING_##ID,
#define LODE_OBSERVER(ID, id, name, STEP, vectors, numbers) LODE_IF_BUILT_IN(ID, ROTATES_##STEP(ID))
    enum {
#include "lodestar/observers.def"
        ROTATING // number of built-in observers that need them
    };
#undef LODE_OBSERVER
#undef ROTATES_CALLED
#undef ROTATES_INLINE
#undef ROTATES_FIXED
#define ROTATES_FIXED(ID)                                                                          \
    if (tuning->kind == (uint32_t)LODE_EMF_##ID) {                                                 \
        return false;                                                                              \
    }
#define ROTATES_INLINE(ID)
#define ROTATES_CALLED(ID)
#define LODE_OBSERVER(ID, id, name, STEP, vectors, numbers) ROTATES_##STEP(ID)
#include "lodestar/observers.def"
    return ROTATING > 0;
#undef LODE_OBSERVER
#undef ROTATES_CALLED
#undef ROTATES_INLINE
#undef ROTATES_FIXED
}

// One period of any observer: the estimate from `m_V`. `step_angle`: w Ts at the speed `omega_rad_s` that the observer is tuned
// to. The hint for C-LESO saves 8 cycles of enhanced with six phases.
LODE_INLINE lode_ab_t lode_observer_step(lode_observer_t *self,
                                         const lode_observer_tuning_t *tuning, lode_ab_t m_V,
                                         lode_sincos_t step_angle, float omega_rad_s) {
#define STEP_INLINE(ID, id)                                                                        \
    if (LODE_USUALLY(tuning->kind == (uint32_t)LODE_EMF_##ID)) {                                   \
        return id##_step(self, tuning, m_V, step_angle, omega_rad_s);                              \
    }
#define STEP_FIXED(ID, id) STEP_INLINE(ID, id)
#define STEP_CALLED(ID, id)
#define LODE_OBSERVER(ID, id, name, STEP, vectors, numbers)                                        \
    LODE_IF_BUILT_IN(ID, STEP_##STEP(ID, id))
#include "lodestar/observers.def"
#undef LODE_OBSERVER
#undef STEP_CALLED
#undef STEP_FIXED
#undef STEP_INLINE
    const lode_ab_t m = {m_V.alpha, m_V.beta}; // copies: the originals stay in registers
    const lode_sincos_t rho = {step_angle.sin, step_angle.cos};
    lode_observer_step_called(self, tuning, m, rho, omega_rad_s);
    return (lode_ab_t){self->e_V.alpha, self->e_V.beta};
}

#endif
