#include "report/report_faults.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "support/units.h"
#include "support/utf8.h"

static const struct {
    int bit;
    const char *word;
} harms[] = {
    {FAULT_HARM_ROTOR, "rotor lost"},   {FAULT_HARM_CURRENT, "current"},
    {FAULT_HARM_CONTROL, "control"},    {FAULT_HARM_SPEED, "speed"},
    {FAULT_HARM_HEAT, "heat"},          {FAULT_HARM_STUCK, "does not run"},
    {FAULT_HARM_DIP, "the speed dips"},
};
#define OVER_SHOWN_s 0.01
enum { HARMS = sizeof harms / sizeof harms[0], BITS_SHOWN = 40 };

static void harm_words(int harm, char *text, size_t size) {
    text[0] = '\0';
    for (int k = 0; k < HARMS; ++k) {
        const size_t used = strlen(text);
        if ((harm & harms[k].bit) != 0) {
            (void)snprintf(text + used, size - used, "%s%s", used > 0 ? ", " : "", harms[k].word);
        }
    }
}

/// The name of a check without its prefix.
static const char *check_word(lode_check_t check) {
    return lode_check_name(check) + strlen("LODE_CHECK_");
}

static void print_time(FILE *file, double time_s) {
    if (time_s < 1.0) {
        (void)fprintf(file, "%.3g ms", 1e3 * time_s);
    } else {
        (void)fprintf(file, "%.3g s", time_s);
    }
}

/// What is put in the place of a character of mark-up, or before it; empty: nothing.
static const char *escape_of(char mark) {
    static const struct {
        char mark;
        const char *text;
    } escapes[] = {{'<', "&lt;"}, {'>', "&gt;"}, {'&', "&amp;"}};
    for (size_t k = 0; k < sizeof escapes / sizeof escapes[0]; ++k) {
        if (escapes[k].mark == mark) {
            return escapes[k].text;
        }
    }
    return strchr("\\`*[]|#~$", mark) != NULL ? "\\" : "";
}

/// A name as text of Markdown, which is also shown on the screen.
static void print_name(FILE *file, const char *text) {
    while (*text != '\0') {
        char shown[4];
        const size_t length = utf8_shown(&text, shown);
        const char *escape = length == 1 ? escape_of(*shown) : "";
        const bool replaced = *escape == '&';
        (void)fprintf(file, "%s%.*s", escape, replaced ? 0 : (int)length, shown);
    }
}

/// The columns: states of the motor in which faults begin.
static int points_of(const fault_bench_t *bench) {
    int points = 0;
    for (int point = 0; point < FAULT_POINTS; ++point) {
        points += bench->left_out[point] ? 0 : 1;
    }
    return points;
}

static void print_cell(FILE *file, const fault_result_t *one) {
    if (one->tried == 0) {
        (void)fprintf(file, " - |");
        return;
    }
    if (one->silent > 0) {
        char words[80];
        harm_words(one->harm, words, sizeof words);
        (void)fprintf(file, " **silent**: %s", words);
    } else if (one->found == LODE_CHECK_NONE) {
        (void)fprintf(file, (one->harm & FAULT_HARM_DIP) != 0 ? " harmless (the speed dips)"
                                                              : " harmless");
    } else {
        (void)fprintf(file, " %s ", check_word(one->found));
        print_time(file, one->found_s);
        if (one->named != one->found && one->named != LODE_CHECK_NONE) {
            (void)fprintf(file, ", then %s", check_word(one->named));
        }
    }
    if (one->tried > 1) {
        (void)fprintf(file, " (silent %d of %d)", one->silent, one->tried);
    }
    (void)fprintf(file, ", %.3g A", one->peak_A);
    if (one->over_s >= OVER_SHOWN_s) {
        (void)fputs(", beyond 1.2 i_max for ", file);
        print_time(file, one->over_s);
    }
    if (one->back_deg >= 1.0) {
        (void)fprintf(file, ", back %.3g deg", one->back_deg);
    }
    if (one->given_up > 0) {
        (void)fprintf(file, ", given up %d", one->given_up);
    }
    (void)fprintf(file, " |");
}

/// Without the number of variants in parentheses, which another number replaces.
static void print_what(FILE *file, const report_faults_t *report, int k) {
    const char *what = report->kind[k]->what;
    const bool by_bit = report->by_bit && inject_bits(report->kind[k]) > 0u;
    const int length = (int)(by_bit ? strcspn(what, "(") - 1u : strlen(what));
    (void)fprintf(file, "| %.*s |", length, what);
}

/// The silent bits of a case, as OFFSET.BIT; returns how many.
static int print_bits(FILE *file, const report_faults_t *report, int n) {
    const inject_kind_t *kind = report->kind[n / FAULT_POINTS];
    int bits = 0;
    for (int k = 0; k < report->bits; ++k) {
        const report_faults_bit_t *one = &report->bit[k];
        if (one->number != report->first + (uint64_t)n) {
            continue;
        }
        if (bits == 0) {
            (void)fprintf(file, "Silent bits of %s at %s:", kind->name,
                          fault_point_name[n % FAULT_POINTS]);
        }
        if (bits < BITS_SHOWN) {
            (void)fprintf(file, " %zu.%u", inject_offset(kind, one->bit),
                          (unsigned)(one->bit % 8u));
        }
        ++bits;
    }
    if (bits > BITS_SHOWN) {
        (void)fprintf(file, " and %d more, see --json", bits - BITS_SHOWN);
    }
    (void)fputs(bits > 0 ? ".\n\n" : "", file);
    return bits;
}

static void print_silent_bits(FILE *file, const report_faults_t *report) {
    int bits = 0;
    for (int n = 0; n < report->kinds * FAULT_POINTS; ++n) {
        bits += print_bits(file, report, n);
    }
    if (bits > 0) {
        (void)fputs("A silent bit: the offset of its octet in lode_drive_t (state, mode), "
                    "lode_drive_tuning_t or lode_order_t of this build, a point, and its number "
                    "in the octet.\n\n",
                    file);
    }
}

int report_faults_table(FILE *file, const report_faults_t *report) {
    const lode_drive_config_t *drive = &report->bench->config.drive;
    const int points = points_of(report->bench);
    const int cases = report->kinds * points;
    int silent = 0;
    int found = 0;
    (void)fputs("## ", file);
    print_name(file, report->motor);
    (void)fprintf(
        file,
        "\n\n%s phases, i_max %.3g A, trip %.3g A, bus %.4g V, %.3g kHz; full speed "
        "%.4g rpm%s%s.\n\n| fault |",
        report->bench->at[0].sets == PLANT_SETS ? "six" : "three", (double)drive->inverter.i_max_A,
        (double)drive->guard.i_trip_A, (double)drive->inverter.v_bus_V,
        1e-3 * (double)drive->f_pwm_Hz, rig_rpm_from_rad_s(report->bench->full_rad_s),
        report->place != NULL ? "; faults in " : "", report->place != NULL ? report->place : "");
    for (int point = 0; point < FAULT_POINTS; ++point) {
        (void)fprintf(file, " %s |", fault_point_name[point]);
    }
    (void)fprintf(file, "\n|---|---|---|---|---|---|---|\n");
    for (int k = 0; k < report->kinds; ++k) {
        print_what(file, report, k);
        for (int point = 0; point < FAULT_POINTS; ++point) {
            const fault_result_t *one = &report->result[k * FAULT_POINTS + point];
            print_cell(file, one);
            silent += fault_is_silent(one) ? 1 : 0;
            found += one->found != LODE_CHECK_NONE ? 1 : 0;
        }
        (void)fprintf(file, "\n");
    }
    (void)fprintf(file, "\n%d cases: %d found, %d harmless, %d silent.\n\n", cases, found,
                  cases - found - silent, silent);
    if (points < FAULT_POINTS) {
        (void)fprintf(
            file, "-: left out, because the speed does not settle there even without a fault.\n\n");
    }
    print_silent_bits(file, report);
    return silent;
}

void report_faults_page(FILE *file, const char *tables) {
    (void)fputs(
        "# Faults\n\n"
        "How the drive responds to faults of its sensors, bridge, timer, supply, motor and "
        "memory. Written by `lodestar faults --out docs/faults.md`; nothing here is written by "
        "hand.\n\n"
        "A fault begins in one of six states: at standstill before calibration, after which half "
        "speed is commanded; during the start; at 10, 50 and 100 % of full speed, but not below "
        "1.25 times the least speed; and with field weakening. There is no load at standstill and "
        "in the start; in RUN it is 0.3 times the torque at i_max, 0.1 times at 10 % and with "
        "field weakening (`--load` sets another). A cell gives the check that found the fault, the "
        "time until then, the largest true phase current, and how far the rotor turned back "
        "(mechanical degrees).\n\n"
        "`harmless`: not found, and nothing went wrong within the observation time of one second "
        "(start: three seconds plus twice its time-out). **silent**: not found, although one of "
        "these held for 10 ms: angle error above 60 degrees (rotor lost), a current vector longer "
        "than 1.2 i_max, a current off its reference by more than 0.3 i_max, a power stage 10 K "
        "above its limit; or although a phase current was beyond 1.2 i_max for 10 ms within 50 ms, "
        "be it in pulses; or although at the end the speed was off by more than 10 % of full "
        "speed, or the drive was not in RUN and reported no reason. Current below its reference, "
        "or above it but within i_max, only changes the torque, as a load does: the speed decides. "
        "`the speed dips`: the speed was off by more than 10 % of full speed for 0.1 s and "
        "recovered. `given up`: the number of start attempts given up right after the hand-over, "
        "from the telemetry's `retries`. What went wrong in such an attempt is thereby reported, "
        "except a current beyond 1.2 i_max for more than 0.1 s. `beyond 1.2 i_max for`: how long "
        "in all, before the fault was found, a vector or a phase current was, from 10 ms on. "
        "`then`: within 20 ms with the gates off the drive has named the cause more closely. Of a "
        "fault with several variants the worst result is shown.\n\n"
        "The simulated inverter switches, with dead time and noise. It has no over-current trip in "
        "hardware, which a real bridge must have: where interrupts are missed or a switch is "
        "shorted, only the motor limits the current. Bus voltage and temperature have a noise of "
        "one count. `guard.temperature_still_s` is 0.5 and `guard.bus_still_s` is 0.1; both are "
        "off by default, and a stuck sensor is then not found.\n\n",
        file);
    (void)fputs(tables, file);
}

cJSON *report_faults_json_root(void) {
    cJSON *root = config_json_root();
    (void)cJSON_AddArrayToObject(root, "cases");
    return root;
}

static void add_bits(cJSON *item, const report_faults_t *report, int n) {
    const inject_kind_t *kind = report->kind[n / FAULT_POINTS];
    if (!report->by_bit || inject_bits(kind) == 0u) {
        return;
    }
    cJSON *bits = cJSON_AddArrayToObject(item, "silent_bits");
    for (int k = 0; k < report->bits; ++k) {
        const report_faults_bit_t *one = &report->bit[k];
        if (one->number == report->first + (uint64_t)n) {
            cJSON *bit = config_json_item(bits);
            (void)cJSON_AddStringToObject(bit, "at", fault_point_name[n % FAULT_POINTS]);
            config_json_number(bit, "number", (double)one->bit);
            config_json_number(bit, "offset", (double)inject_offset(kind, one->bit));
            config_json_number(bit, "bit", (double)(one->bit % 8u));
        }
    }
}

void report_faults_json(cJSON *root, const report_faults_t *report) {
    cJSON *cases = root != NULL ? cJSON_GetObjectItem(root, "cases") : NULL;
    for (int n = 0; cases != NULL && n < report->kinds * FAULT_POINTS; ++n) {
        const fault_result_t *one = &report->result[n];
        if (one->tried == 0) {
            continue;
        }
        char words[80];
        cJSON *item = config_json_item(cases);
        harm_words(one->harm, words, sizeof words);
        (void)cJSON_AddStringToObject(item, "motor", report->motor);
        (void)cJSON_AddStringToObject(item, "kind", report->kind[n / FAULT_POINTS]->name);
        (void)cJSON_AddStringToObject(item, "in", report->place != NULL ? report->place : "a1");
        (void)cJSON_AddStringToObject(item, "at", fault_point_name[n % FAULT_POINTS]);
        (void)cJSON_AddStringToObject(item, "found", check_word(one->found));
        (void)cJSON_AddStringToObject(item, "named", check_word(one->named));
        (void)cJSON_AddBoolToObject(item, "silent", fault_is_silent(one));
        (void)cJSON_AddStringToObject(item, "harm", words);
        config_json_number(item, "found_s", one->found_s);
        config_json_number(item, "peak_A", one->peak_A);
        config_json_number(item, "over_s", one->over_s);
        config_json_number(item, "back_deg", one->back_deg);
        config_json_number(item, "given_up", one->given_up);
        config_json_number(item, "tried", one->tried);
        config_json_number(item, "silent_of_tried", one->silent);
        add_bits(item, report, n);
    }
}
