/// Every field of a configuration at, inside and outside its range, NaN and Inf.
#ifndef SUPPORT_FIELDS_H
#define SUPPORT_FIELDS_H

#include "support/check.h"

#include "lodestar/status.h"

/// A float field of a configuration struct.
typedef struct {
    const char *name;
    size_t offset;
    float lo; ///< least value that is accepted
    float hi; ///< largest value that is accepted
    lode_status_t error;
    bool computed;     ///< a limit is computed: 0.2 % either side of it instead of the next float
    bool zero_is_auto; ///< 0 asks for the default, and is accepted whatever `lo`
    bool coupled;      ///< at its limits another check may refuse, but not with this error
} field_t;

#define FIELD(type, member) .name = #member, .offset = offsetof(type, member)

/// Sets the field of a fresh configuration and returns what the module under test says of it; fails
/// by itself where the module refuses and yet touches its object.
typedef lode_status_t (*field_try_t)(size_t offset, float value);

static inline void field_set(void *config, size_t offset, float value) {
    memcpy((char *)config + offset, &value, sizeof value);
}

static inline float field_get(const void *config, size_t offset) {
    float value;
    memcpy(&value, (const char *)config + offset, sizeof value);
    return value;
}

static inline float field_beyond(const field_t *field, float limit, float towards) {
    if (!field->computed) {
        return nextafterf(limit, towards);
    }
    const float step = 2.0e-3f * fabsf(limit);
    return towards > limit ? limit + step : limit - step;
}

static inline void field_refused(const field_t *field, field_try_t try_one, float value) {
    char text[120];
    (void)snprintf(text, sizeof text, "%s = %.9g", field->name, (double)value);
    TEST_ASSERT_EQUAL_STRING_MESSAGE(lode_status_name(field->error),
                                     lode_status_name(try_one(field->offset, value)), text);
}

static inline void field_accepted(const field_t *field, field_try_t try_one, float value) {
    char text[120];
    (void)snprintf(text, sizeof text, "%s = %.9g", field->name, (double)value);
    const lode_status_t status = try_one(field->offset, value);
    if (field->coupled) {
        TEST_ASSERT_TRUE_MESSAGE(status != field->error, text);
    } else {
        TEST_ASSERT_EQUAL_STRING_MESSAGE("LODE_OK", lode_status_name(status), text);
    }
}

/// Not finite: refused.
static inline void field_check_numbers(const field_t *field, field_try_t try_one) {
    field_refused(field, try_one, NAN);
    field_refused(field, try_one, INFINITY);
    field_refused(field, try_one, FLT_MAX);
    if (!field->zero_is_auto) {
        field_refused(field, try_one, -INFINITY);
        field_refused(field, try_one, -FLT_MAX);
    }
}

/// Not finite, at, inside and outside.
static inline void field_check(const field_t *field, field_try_t try_one) {
    field_check_numbers(field, try_one);
    const float below = field_beyond(field, field->lo, -INFINITY);
    if (below > 0.0f || (below < 0.0f && !field->zero_is_auto)) {
        field_refused(field, try_one, below);
    }
    field_refused(field, try_one, field_beyond(field, field->hi, INFINITY));
    const float lo = field->computed ? field_beyond(field, field->lo, INFINITY) : field->lo;
    const float hi = field->computed ? field_beyond(field, field->hi, -INFINITY) : field->hi;
    field_accepted(field, try_one, lo);
    field_accepted(field, try_one, hi);
    field_accepted(field, try_one, lo + 0.5f * (hi - lo));
    if (field->zero_is_auto) {
        field_accepted(field, try_one, 0.0f);
    }
}

/// Only zero asks for a default: below it there is no value to choose.
static inline void field_check_negative(const field_t *field, field_try_t try_one) {
    field_refused(field, try_one, -1.0e-3f);
    field_refused(field, try_one, -5.0f);
    field_refused(field, try_one, -FLT_MAX);
    field_refused(field, try_one, -INFINITY);
}

static inline void field_check_all(const field_t *fields, int count, field_try_t try_one) {
    for (int i = 0; i < count; i++) {
        field_check(&fields[i], try_one);
    }
}

#endif
