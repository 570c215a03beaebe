#include "report.h"

#include "board.h"

#define LINE_MAX 96u
#define THOUSAND 1000.0f
#define EXPONENT_MAX 45  // of a float, denormals included
#define VALUE_MAX 2.0e6f // thousandths of it fit 32 bits

static uint16_t line[LINE_MAX];
static uint32_t length;
static uint32_t sent;
static uint_least8_t state_reported;
static uint_least8_t mode_reported;

static void put(char c) {
    if (length < LINE_MAX) {
        line[length++] = (uint16_t)c;
    }
}

static void put_text(const char *text) {
    for (; *text != '\0'; text++) {
        put(*text);
    }
}

static void put_digits(uint32_t value, uint32_t least) {
    char digits[10];
    uint32_t count = 0u;
    while (value > 0u || count < least) {
        digits[count++] = (char)('0' + (char)(value % 10u));
        value /= 10u;
    }
    while (count > 0u) {
        put(digits[--count]);
    }
}

// Three decimals; out of range, NaN included, as ends of the range.
static void put_float(float value) {
    const float x = value > -VALUE_MAX ? lode_min(value, VALUE_MAX) : -VALUE_MAX;
    const uint32_t thousandths = (uint32_t)(lode_abs(x) * THOUSAND + 0.5f);
    if (x < 0.0f) {
        put('-');
    }
    put_digits(thousandths / 1000u, 1u);
    put('.');
    put_digits(thousandths % 1000u, 3u);
}

void report_event(const char *what, const char *name, uint32_t number) {
    if (sent == length) {
        length = 0u;
        sent = 0u;
    }
    put_text(what);
    put(' ');
    put_text(name);
    put(' ');
    put_digits(number, 1u);
    put_text("\r\n");
}

// Five digits and an exponent.
static void put_scientific(float value) {
    const float ten = 10.0f;
    const float unit = 10000.0f;
    float x = lode_abs(value);
    int32_t exponent = 0;
    while (x >= ten && exponent < EXPONENT_MAX) {
        x /= ten;
        exponent++;
    }
    while (x > 0.0f && x < 1.0f && exponent > -EXPONENT_MAX) {
        x *= ten;
        exponent--;
    }
    uint32_t digits = x < ten ? (uint32_t)(x * unit + 0.5f) : 0u;
    if (digits == (uint32_t)(ten * unit)) {
        digits = (uint32_t)unit;
        exponent++;
    }
    if (value < 0.0f) {
        put('-');
    }
    put_digits(digits / (uint32_t)unit, 1u);
    put('.');
    put_digits(digits % (uint32_t)unit, 4u);
    put_text(exponent < 0 ? "e-" : "e+");
    put_digits((uint32_t)(exponent < 0 ? -exponent : exponent), 2u);
}

bool report_is_sent(void) {
    return sent == length;
}

void report_line(const char *text) {
    length = 0u;
    sent = 0u;
    put_text(text);
    put_text("\r\n");
}

void report_setting(const char *key, float value, float confidence) {
    length = 0u;
    sent = 0u;
    put_text(key);
    put_text(" = ");
    put_scientific(value);
    if (confidence < 0.0f) {
        put_text(" ; given");
    } else {
        put_text(" ; confidence ");
        put_float(confidence);
    }
    put_text("\r\n");
}

static void compose(const bringup_result_t *result) {
    length = 0u;
    sent = 0u;
    put_digits(result->mode, 1u);
    put(' ');
    put_text(bringup_state_name(result->state));
    put(' ');
    put_text(bringup_reason_name(result->reason));
    if (result->reason == (uint_least8_t)BRINGUP_FAULT) {
        put_text(" check ");
        put_digits(result->check, 1u);
    }
    put_text(" phase ");
    put_digits(result->phase, 1u);
    put_text(" measured ");
    put_float(result->measured);
    put_text(" limit ");
    put_float(result->limit);
    put_text("\r\n");
}

void report_poll(const bringup_result_t *result) {
    if (sent < length) {
        sent += board_send(&line[sent], length - sent);
        return;
    }
    if (result->mode != mode_reported || result->state != state_reported) {
        mode_reported = result->mode;
        state_reported = result->state;
        if (result->state != (uint_least8_t)BRINGUP_RUNNING) {
            compose(result);
        }
    }
}
