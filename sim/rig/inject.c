#include "rig/inject.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "config/speed_limits.h"

#define DRIFT_s 0.1
#define BUS_MOVES_s 0.05
#define HEATS_s 0.3
#define HOT_degC 140.0

const inject_kind_t inject_kinds[] = {
    {"none", "nothing", INJECT_NOTHING, false, 0.0},
    {"adc-frozen", "all current ADC channels keep their last count", INJECT_FREEZE, true, 0.0},
    {"adc-frozen-noisy", "all current ADC channels keep their last count, with noise of one count",
     INJECT_FREEZE_NOISY, true, 0.0},
    {"adc-last", "one current ADC channel keeps its last count", INJECT_HOLD, false, 0.0},
    {"adc-mid", "one current ADC channel reads mid-range", INJECT_COUNT, false, 0.5},
    {"adc-mid-all", "all current ADC channels read mid-range", INJECT_COUNT, true, 0.5},
    {"adc-mid-all-noisy", "all current ADC channels read mid-range, with noise of one count",
     INJECT_COUNT_NOISY, true, 0.5},
    {"adc-high", "one current ADC channel reads full scale", INJECT_COUNT, false, 1.0},
    {"adc-low", "one current ADC channel reads 0", INJECT_COUNT, false, 0.0},
    {"adc-60", "one current ADC channel reads 60 % of full scale", INJECT_COUNT, false, 0.6},
    {"gain-0.4", "one current gain falls to 0.4", INJECT_GAIN, false, 0.4},
    {"gain-0.7", "one current gain falls to 0.7", INJECT_GAIN, false, 0.7},
    {"gain-1.5", "one current gain rises to 1.5", INJECT_GAIN, false, 1.5},
    {"gains-0.4", "all current gains fall to 0.4", INJECT_GAIN, true, 0.4},
    {"gains-0.7", "all current gains fall to 0.7", INJECT_GAIN, true, 0.7},
    {"gains-1.5", "all current gains rise to 1.5", INJECT_GAIN, true, 1.5},
    {"offset-12", "one current offset drifts by 12 % of i_max", INJECT_OFFSET, false, 0.12},
    {"offset-25", "one current offset drifts by 25 % of i_max", INJECT_OFFSET, false, 0.25},
    {"offsets-25", "all current offsets drift by 25 % of i_max", INJECT_OFFSET, true, 0.25},
    {"sensors-swapped", "the current sensors of two phases are swapped", INJECT_SWAP, false, 0.0},
    {"sensors-rotated", "the current sensors of phases a, b, c measure b, c, a", INJECT_ROTATE,
     false, 0.0},
    {"switch-high-dead", "the high switch of a phase no longer turns on", INJECT_DEAD, false, 1.0},
    {"switch-low-dead", "the low switch of a phase no longer turns on", INJECT_DEAD, false, 0.0},
    {"leg-dead", "neither switch of a phase turns on", INJECT_DEAD, false, 2.0},
    {"switch-high-shorted", "the high switch of a phase is shorted", INJECT_SHORT, false, 1.0},
    {"switch-low-shorted", "the low switch of a phase is shorted", INJECT_SHORT, false, 0.0},
    {"phase-open", "the wire of a phase breaks", INJECT_OPEN, false, 0.0},
    {"duties-late", "the duties act one period late", INJECT_LATE, true, 0.0},
    {"duties-early", "the duties act one period early", INJECT_EARLY, true, 0.0},
    {"register-last", "the duty of a phase stays as it was", INJECT_REGISTER, false, -1.0},
    {"register-0", "the duty of a phase stays 0", INJECT_REGISTER, false, 0.0},
    {"register-1", "the duty of a phase stays 1", INJECT_REGISTER, false, 1.0},
    {"bus-stuck-sags", "the bus sensor is stuck, the bus sags by 15 %", INJECT_BUS_HOLD, true,
     -0.15},
    {"bus-stuck-rises", "the bus sensor is stuck, the bus rises by 15 %", INJECT_BUS_HOLD, true,
     0.15},
    {"bus-reads-0", "the bus sensor reads 0", INJECT_BUS_READ, true, 0.0},
    {"bus-reads-full", "the bus sensor reads full scale", INJECT_BUS_READ, true, 1.0},
    {"ntc-stuck", "the temperature sensor is stuck, the power stage heats up to 140 degC",
     INJECT_NTC_HOLD, true, 0.0},
    {"ntc-low", "the temperature sensor reads 0, the power stage heats up", INJECT_NTC_READ, true,
     0.0},
    {"ntc-high", "the temperature sensor reads full scale", INJECT_NTC_READ, true, 1.0},
    {"irq-missed", "one interrupt is missed", INJECT_MISS, true, 1.0},
    {"irq-missed-100", "100 interrupts in a row are missed", INJECT_MISS, true, 100.0},
    {"irq-missed-each", "every 10th interrupt is missed", INJECT_MISS_EACH, true, 10.0},
    {"irq-doubled", "one interrupt comes twice", INJECT_DOUBLE, true, 1.0},
    {"irq-doubled-each", "every 10th interrupt comes twice", INJECT_DOUBLE_EACH, true, 10.0},
    {"flux-70", "the magnets lose 30 % of their flux", INJECT_FLUX, true, 0.7},
    {"rotor-jammed", "the rotor is jammed", INJECT_JAM, true, 0.0},
    {"overhauled-back", "the load turns the rotor backwards with twice the torque of i_max",
     INJECT_OVERHAUL, true, -2.0},
    {"overhauled-on", "the load turns the rotor forwards with twice the torque of i_max",
     INJECT_OVERHAUL, true, 2.0},
    {"flip-tuning", "a bit of the tuning flips (16 bits tried)", INJECT_FLIP_TUNING, true, 0.0},
    {"flip-state", "a bit of the drive's state flips (16 bits tried)", INJECT_FLIP_STATE, true,
     0.0},
    {"flip-mode", "a bit of the mode flips (each of 8 bits, twice)", INJECT_FLIP_MODE, true, 0.0},
    {"flip-command", "a bit of the command flips (16 bits tried)", INJECT_FLIP_COMMAND, true, 0.0},
};
const int inject_kind_count = (int)(sizeof inject_kinds / sizeof inject_kinds[0]);
typedef char kinds_fit[sizeof inject_kinds / sizeof inject_kinds[0] <= INJECT_KINDS_MAX ? 1 : -1];

bool inject_is_random(const inject_kind_t *kind) {
    return kind->how == INJECT_FLIP_TUNING || kind->how == INJECT_FLIP_STATE ||
           kind->how == INJECT_FLIP_MODE || kind->how == INJECT_FLIP_COMMAND;
}

void inject_init(inject_t *self, const inject_kind_t *kind, inject_place_t place,
                 const rig_config_t *config, const plant_config_t *plant, uint64_t seed) {
    *self = (inject_t){
        .kind = kind,
        .place = place,
        .seed = seed,
        .bit = INJECT_ANY_BIT,
        .ts_s = plant->period_s,
        .i_max_A = (double)config->drive.inverter.i_max_A,
        .i_A_per_count = plant->i_A_per_count,
        .full_count = exp2(plant->adc_bits) - 1.0,
        .torque_Nm =
            speed_limits_torque_Nm(&config->drive, (double)config->drive.motor.omega_rated_rad_s),
        .v_bus_V = plant->v_bus_V,
        .temperature_degC = plant->temperature_degC,
    };
}

/// Rises from 0 to 1 within `time_s` of the start of the fault.
static double ramp(const inject_t *self, double time_s) {
    return fmin(1.0, (double)self->periods * self->ts_s / time_s);
}

static uint16_t count_of(const inject_t *self, double x) {
    return (uint16_t)fmax(0.0, fmin(self->full_count, floor(x + 0.5)));
}

/// splitmix64
static uint64_t mixed(uint64_t x) {
    uint64_t z = x * UINT64_C(0x9E3779B97F4A7C15) + UINT64_C(0x632BE59BD9B4E019);
    z = (z ^ (z >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94D049BB133111EB);
    return z ^ z >> 31;
}

// ---- What the drive reads -----------------------------------------------------------------------

/// One count up, down, or none: the noise of an amplifier without a signal.
static double noise(const inject_t *self, int set, int n) {
    const uint64_t channel = (uint64_t)(set * PLANT_PHASES + n);
    const uint64_t sample = self->periods * PLANT_LEGS + channel;
    return (double)(mixed(mixed(self->seed) ^ sample) % 3u) - 1.0;
}

static void spoil_current(const inject_t *self, int set, int n, uint16_t *count) {
    const double middle = 0.5 * (self->full_count + 1.0);
    const double x = (double)*count - middle;
    switch (self->kind->how) {
    case INJECT_FREEZE:
    case INJECT_HOLD:
        *count = self->held[set].i[n];
        break;
    case INJECT_COUNT:
        *count = count_of(self, self->kind->value * (self->full_count + 1.0));
        break;
    case INJECT_FREEZE_NOISY:
        *count = count_of(self, (double)self->held[set].i[n] + noise(self, set, n));
        break;
    case INJECT_COUNT_NOISY:
        *count = count_of(self, self->kind->value * (self->full_count + 1.0) + noise(self, set, n));
        break;
    case INJECT_GAIN:
        *count = count_of(self, middle + self->kind->value * x);
        break;
    case INJECT_OFFSET:
        *count = count_of(self, middle + x +
                                    ramp(self, DRIFT_s) * self->kind->value * self->i_max_A /
                                        self->i_A_per_count);
        break;
    default:
        break;
    }
}

static void spoil_order(const inject_t *self, plant_counts_t *counts) {
    const plant_counts_t is = *counts;
    if (self->kind->how == INJECT_SWAP || self->kind->how == INJECT_ROTATE) {
        counts->i[0] = is.i[1];
        counts->i[1] = self->kind->how == INJECT_SWAP ? is.i[0] : is.i[2];
        counts->i[2] = self->kind->how == INJECT_SWAP ? is.i[2] : is.i[0];
    }
}

static void spoil_slow(const inject_t *self, int set, plant_counts_t *counts) {
    const double full = self->kind->value * self->full_count;
    switch (self->kind->how) {
    case INJECT_BUS_HOLD:
        counts->v_bus = self->held[set].v_bus;
        break;
    case INJECT_BUS_READ:
        counts->v_bus = count_of(self, full);
        break;
    case INJECT_NTC_HOLD:
        counts->temperature = self->held[set].temperature;
        break;
    case INJECT_NTC_READ:
        counts->temperature = count_of(self, full);
        break;
    default:
        break;
    }
}

static bool is_in_set(const inject_t *self, int set) {
    const inject_place_t *place = &self->place;
    return place->set == INJECT_BOTH_SETS || place->set == set;
}

static bool is_in_phase(const inject_t *self, int set, int n) {
    return self->kind->all ? is_in_set(self, set) : set * PLANT_PHASES + n == self->place.leg;
}

static void spoil_counts(inject_t *self, int sets, plant_counts_t counts[PLANT_SETS]) {
    for (int set = 0; set < sets; ++set) {
        if (self->periods == 0) {
            self->held[set] = counts[set];
        }
        for (int n = 0; n < PLANT_PHASES; ++n) {
            if (is_in_phase(self, set, n)) {
                spoil_current(self, set, n, &counts[set].i[n]);
            }
        }
        if (set == self->place.leg / PLANT_PHASES) {
            spoil_order(self, &counts[set]);
        }
        spoil_slow(self, set, &counts[set]);
    }
}

// ---- Memory -------------------------------------------------------------------------------------

/// Of the state, without pointers: they are addresses of the host, and a flipped one would point to no memory here.
#define STATE_FROM offsetof(lode_drive_t, steps)
#define STATE_TO offsetof(lode_drive_t, posted_tuning)

uint64_t inject_bits(const inject_kind_t *kind) {
    switch (kind->how) {
    case INJECT_FLIP_TUNING:
        return 8u * sizeof(lode_drive_tuning_t);
    case INJECT_FLIP_STATE:
        return 8u * (STATE_TO - STATE_FROM);
    case INJECT_FLIP_MODE:
        return 8u;
    case INJECT_FLIP_COMMAND:
        return 8u * sizeof(lode_order_t);
    default:
        return 0u;
    }
}

size_t inject_offset(const inject_kind_t *kind, uint64_t bit) {
    const size_t from = kind->how == INJECT_FLIP_STATE  ? STATE_FROM
                        : kind->how == INJECT_FLIP_MODE ? offsetof(lode_drive_t, mode)
                                                        : 0u;
    return from + (size_t)(bit / 8u);
}

/// What inject_offset() counts from.
static unsigned char *structure_of(const inject_t *self, rig_t *rig) {
    switch (self->kind->how) {
    case INJECT_FLIP_TUNING: // the tuning in use: that of both sets if there are two
        return rig->sets == PLANT_SETS ? (unsigned char *)&rig->six_tuning[0].drive
                                       : (unsigned char *)&rig->three_tuning[0];
    case INJECT_FLIP_COMMAND:
        return (unsigned char *)&rig->drive->command;
    default:
        return (unsigned char *)rig->drive;
    }
}

static uint64_t drawn_bit(const inject_t *self, uint64_t bits) {
    const uint64_t z = mixed(self->seed);
    return self->kind->how == INJECT_FLIP_MODE ? self->seed % bits
                                               : 8u * (z % (bits / 8u)) + (z >> 32) % 8u;
}

static void flip_memory(const inject_t *self, rig_t *rig) {
    const uint64_t bits = inject_bits(self->kind);
    if (bits > 0u) {
        const uint64_t bit = self->bit == INJECT_ANY_BIT ? drawn_bit(self, bits) : self->bit;
        unsigned char *octet = structure_of(self, rig) + inject_offset(self->kind, bit);
        *octet = (unsigned char)(*octet ^ (1u << bit % 8u));
    }
}

// ---- Motor, bridge, supply ----------------------------------------------------------------------

static void begin(inject_t *self, rig_t *rig) {
    plant_t *plant = &rig->plant;
    const int leg = self->place.leg;
    const double value = self->kind->value;
    switch (self->kind->how) {
    case INJECT_DEAD:
        if (value > 0.5) {
            plant_fail_switch(plant, leg, true, false);
        }
        if (value < 0.5 || value > 1.5) {
            plant_fail_switch(plant, leg, false, false);
        }
        break;
    case INJECT_SHORT:
        plant_fail_switch(plant, leg, value > 0.5, true);
        break;
    case INJECT_OPEN:
        plant_open_phase(plant, leg);
        break;
    case INJECT_FLUX:
        plant_set_flux(plant, value * plant->motor.psi_Wb);
        break;
    case INJECT_JAM:
        plant_set_speed(plant, 0.0);
        break;
    case INJECT_OVERHAUL:
        plant->motor.load_is_passive = false;
        plant_set_load(plant, -value * self->torque_Nm);
        break;
    default:
        flip_memory(self, rig);
        break;
    }
}

static void move(const inject_t *self, plant_t *plant) {
    if (self->kind->how == INJECT_BUS_HOLD) {
        plant_set_bus(plant, self->v_bus_V * (1.0 + self->kind->value * ramp(self, BUS_MOVES_s)));
    }
    if (self->kind->how == INJECT_NTC_HOLD || self->kind->how == INJECT_NTC_READ) {
        plant_set_temperature(plant, self->temperature_degC +
                                         (HOT_degC - self->temperature_degC) * ramp(self, HEATS_s));
    }
}

// ---- What the drive writes, and when ------------------------------------------------------------

static void write_duties(inject_t *self, rig_t *rig, int set, const lode_drive_out_t *out) {
    double duty[PLANT_PHASES] = {(double)out->duty.a, (double)out->duty.b, (double)out->duty.c};
    const int how = self->kind->how;
    double *before = &self->late[set * PLANT_PHASES];
    const int leg = self->place.leg;
    if (how == INJECT_REGISTER && set == leg / PLANT_PHASES) {
        const int n = leg % PLANT_PHASES;
        before[n] = self->periods == 0 ? rig->plant.next_duty[leg] : before[n];
        duty[n] = self->kind->value < 0.0 ? before[n] : self->kind->value;
    }
    if (how == INJECT_LATE) {
        double was[PLANT_PHASES];
        memcpy(was, self->periods == 0 ? duty : before, sizeof was);
        memcpy(before, duty, sizeof duty);
        memcpy(duty, was, sizeof duty);
    }
    plant_write_set(&rig->plant, set, duty, (plant_gates_t)out->gates); // the same three values
}

/// Number of interrupts in this period.
static int calls_now(const inject_t *self) {
    const double n = (double)self->periods;
    const double value = self->kind->value;
    switch (self->kind->how) {
    case INJECT_MISS:
        return n < value ? 0 : 1;
    case INJECT_MISS_EACH:
        return self->periods % (uint64_t)value == 0 ? 0 : 1;
    case INJECT_DOUBLE:
        return n < 1.0 ? 2 : 1;
    case INJECT_DOUBLE_EACH:
        return self->periods % (uint64_t)value == 0 ? 2 : 1;
    default:
        return 1;
    }
}

static void call(inject_t *self, rig_t *rig, const plant_counts_t sampled[PLANT_SETS]) {
    if (rig->sets == PLANT_SETS) {
        const lode_counts6_t counts = {{rig_counts(&sampled[0]), rig_counts(&sampled[1])}};
        const lode_drive6_out_t out = lode_drive6_step(&rig->six, &counts);
        write_duties(self, rig, 0, &out.set[0]);
        write_duties(self, rig, 1, &out.set[1]);
        return;
    }
    const lode_counts_t counts = rig_counts(&sampled[0]);
    const lode_drive_out_t out = lode_drive_step(&rig->three, &counts);
    write_duties(self, rig, 0, &out);
}

void inject_step(inject_t *self, rig_t *rig, plant_truth_t *truth) {
    plant_counts_t sampled[PLANT_SETS];
    if (self->periods == 0) {
        begin(self, rig);
    }
    move(self, &rig->plant);
    plant_sample(&rig->plant, sampled, truth);
    spoil_counts(self, rig->sets, sampled);
    for (int n = calls_now(self); n > 0; --n) {
        call(self, rig, sampled);
    }
    if (self->kind->how == INJECT_EARLY) {
        plant_write_through(&rig->plant);
    }
    plant_advance(&rig->plant);
    self->periods++;
}
