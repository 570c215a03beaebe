/// Parts that a build leaves out: LODE_WITHOUT_..., listed in docs/configuration.md. Define an option by
/// `-DLODE_WITHOUT_HFI` or as 1, for the library and for everything that includes its headers.
///
/// Options that change a public header are part of the names of the functions that begin a drive: with LODE_WITHOUT_HFI
/// and LODE_WITHOUT_NOTCH, lode_drive_init() is the symbol `lode_drive_init_no_hfi_no_notch`. A program and a library
/// that were built with different options, and so with structs of different layout, do not link.
#ifndef LODESTAR_OPTIONS_H
#define LODESTAR_OPTIONS_H

// One part needs another.
#if defined(LODE_WITHOUT_PRECHARGE) && !defined(LODE_WITHOUT_FLYING_START)
#define LODE_WITHOUT_FLYING_START 1
#endif
#if defined(LODE_WITHOUT_FLYING_START) && !defined(LODE_WITHOUT_SIGNAL_CHECK)
#define LODE_WITHOUT_SIGNAL_CHECK 1
#endif

// LODE_TAG_<ID>(name): `name`, with a tag if LODE_WITHOUT_<ID> is defined.
#define LODE_TAGGED(name, tag) LODE_TAGGED_BY(name, tag)
#define LODE_TAGGED_BY(name, tag) name##tag

// LODE_TAG_OBSERVERS(name): all tags of EMF observers.
#define LODE_OBSERVER_TAGS
#include "lodestar/observers.def"
#undef LODE_OBSERVER_TAGS

// All other options that change a public header; tests/test_options.sh finds one that is missing.
#ifdef LODE_WITHOUT_HFI
#define LODE_TAG_HFI(name) LODE_TAGGED(name, _no_hfi)
#else
#define LODE_TAG_HFI(name) name
#endif
#ifdef LODE_WITHOUT_NOTCH
#define LODE_TAG_NOTCH(name) LODE_TAGGED(name, _no_notch)
#else
#define LODE_TAG_NOTCH(name) name
#endif
#ifdef LODE_WITHOUT_PLAUSIBILITY
#define LODE_TAG_PLAUSIBILITY(name) LODE_TAGGED(name, _no_plausibility)
#else
#define LODE_TAG_PLAUSIBILITY(name) name
#endif
#ifdef LODE_WITHOUT_TUNING_CHECK
#define LODE_TAG_TUNING_CHECK(name) LODE_TAGGED(name, _no_tuning_check)
#else
#define LODE_TAG_TUNING_CHECK(name) name
#endif
#ifdef LODE_WITHOUT_COMMISSIONING
#define LODE_TAG_COMMISSIONING(name) LODE_TAGGED(name, _no_commissioning)
#else
#define LODE_TAG_COMMISSIONING(name) name
#endif
#ifdef LODE_WITHOUT_TORQUE_LIMITS
#define LODE_TAG_TORQUE_LIMITS(name) LODE_TAGGED(name, _no_torque_limits)
#else
#define LODE_TAG_TORQUE_LIMITS(name) name
#endif
#ifdef LODE_WITHOUT_SHAPED_RAMP
#define LODE_TAG_SHAPED_RAMP(name) LODE_TAGGED(name, _no_shaped_ramp)
#else
#define LODE_TAG_SHAPED_RAMP(name) name
#endif
#ifdef LODE_WITHOUT_ACTIVE_SHORT
#define LODE_TAG_ACTIVE_SHORT(name) LODE_TAGGED(name, _no_active_short)
#else
#define LODE_TAG_ACTIVE_SHORT(name) name
#endif
#ifdef LODE_WITHOUT_FLYING_START
#define LODE_TAG_FLYING_START(name) LODE_TAGGED(name, _no_flying_start)
#else
#define LODE_TAG_FLYING_START(name) name
#endif
#ifdef LODE_WITHOUT_SIGNAL_CHECK
#define LODE_TAG_SIGNAL_CHECK(name) LODE_TAGGED(name, _no_signal_check)
#else
#define LODE_TAG_SIGNAL_CHECK(name) name
#endif
#ifdef LODE_WITHOUT_START_MEASUREMENT
#define LODE_TAG_START_MEASUREMENT(name) LODE_TAGGED(name, _no_start_measurement)
#else
#define LODE_TAG_START_MEASUREMENT(name) name
#endif
#ifdef LODE_WITHOUT_HANDOVER_RETRY
#define LODE_TAG_HANDOVER_RETRY(name) LODE_TAGGED(name, _no_handover_retry)
#else
#define LODE_TAG_HANDOVER_RETRY(name) name
#endif

// The symbol of `function`; its plain name if nothing is left out.
#define LODE_SYMBOL(function) LODE_TAG_PARTS(LODE_TAG_START(LODE_TAG_OBSERVERS(function)))
#define LODE_TAG_PARTS(name)                                                                       \
    LODE_TAG_HFI(                                                                                  \
        LODE_TAG_NOTCH(LODE_TAG_PLAUSIBILITY(LODE_TAG_TUNING_CHECK(LODE_TAG_COMMISSIONING(         \
            LODE_TAG_TORQUE_LIMITS(LODE_TAG_SHAPED_RAMP(LODE_TAG_ACTIVE_SHORT(name))))))))
#define LODE_TAG_START(name)                                                                       \
    LODE_TAG_FLYING_START(                                                                         \
        LODE_TAG_SIGNAL_CHECK(LODE_TAG_START_MEASUREMENT(LODE_TAG_HANDOVER_RETRY(name))))

#endif
