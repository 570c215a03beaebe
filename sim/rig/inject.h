/// Faults of a drive's hardware and memory, inserted between its step and the plant.
#ifndef RIG_INJECT_H
#define RIG_INJECT_H

#include <stddef.h>

#include "rig/rig.h"

typedef enum {
    INJECT_NOTHING,      ///< no fault, for comparison
    INJECT_FREEZE,       ///< all current ADC channels keep their last count
    INJECT_HOLD,         ///< one current ADC channel keeps its last count
    INJECT_COUNT,        ///< one, or all, of them read `value` of full scale
    INJECT_FREEZE_NOISY, ///< as INJECT_FREEZE, with noise of one count
    INJECT_COUNT_NOISY,  ///< as INJECT_COUNT, with noise of one count
    INJECT_GAIN,         ///< one, or all, read `value` times the current
    INJECT_OFFSET,       ///< one, or all, drift by `value` of i_max within 0.1 s
    INJECT_SWAP,         ///< the sensors of two phases are swapped
    INJECT_ROTATE,       ///< the sensors of all three phases are rotated
    INJECT_DEAD,     ///< the high (1) or low (0) switch of a phase no longer turns on; 2: neither
    INJECT_SHORT,    ///< the high (1) or low (0) switch of a phase is shorted
    INJECT_OPEN,     ///< the wire of a phase breaks
    INJECT_LATE,     ///< duties act one period late
    INJECT_EARLY,    ///< duties act one period early
    INJECT_REGISTER, ///< the duty of a phase keeps its last value (`value` < 0) or is `value`
    INJECT_BUS_HOLD, ///< the bus sensor keeps its reading while the bus changes by the share `value` within 50 ms
    INJECT_BUS_READ,    ///< the bus sensor reads `value` of full scale
    INJECT_NTC_HOLD,    ///< the temperature sensor keeps its reading while the power stage heats up
    INJECT_NTC_READ,    ///< the temperature sensor reads `value` of full scale
    INJECT_MISS,        ///< `value` interrupts in a row are missed
    INJECT_MISS_EACH,   ///< one of `value` interrupts
    INJECT_DOUBLE,      ///< one interrupt comes twice
    INJECT_DOUBLE_EACH, ///< one of `value` interrupts
    INJECT_FLUX,        ///< the magnets keep `value` of their flux
    INJECT_JAM,         ///< the rotor is jammed
    INJECT_OVERHAUL,    ///< the load turns the rotor with `value` times the torque of i_max
    INJECT_FLIP_TUNING, ///< a bit of the tuning flips
    INJECT_FLIP_STATE,  ///< a bit of the drive's state flips
    INJECT_FLIP_MODE,   ///< a bit of the mode flips
    INJECT_FLIP_COMMAND ///< a bit of the command in use flips
} inject_how_t;

typedef struct {
    const char *name;
    const char *what; ///< in words
    int how;          ///< inject_how_t
    bool all;         ///< all phases, not only one
    double value;
} inject_kind_t;

/// Where a fault is.
typedef struct {
    int leg; ///< of a fault of one phase: 0 .. 5 for a1, b1, c1, a2, b2, c2
    int set; ///< of a fault of all phases: 0 or 1; INJECT_BOTH_SETS
} inject_place_t;

enum { INJECT_BOTH_SETS = -1 };

enum { INJECT_KINDS_MAX = 64 };

/// All kinds of fault, and their number.
extern const inject_kind_t inject_kinds[];
extern const int inject_kind_count;

/// True for a kind that flips a bit of memory, and so has several variants.
bool inject_is_random(const inject_kind_t *kind);

/// Number of bits that such a kind may flip; 0 for other kinds.
uint64_t inject_bits(const inject_kind_t *kind);

/// Offset of the octet of one of these bits in the library's structure: lode_drive_t (state, mode), lode_drive_tuning_t,
/// lode_order_t.
size_t inject_offset(const inject_kind_t *kind, uint64_t bit);

/// The bit is drawn by the seed.
#define INJECT_ANY_BIT UINT64_MAX

typedef struct {
    const inject_kind_t *kind;
    inject_place_t place;
    uint64_t seed;
    uint64_t bit;     ///< of a kind that flips one: its number, or INJECT_ANY_BIT
    uint64_t periods; ///< since the fault began
    double ts_s, i_max_A, i_A_per_count, full_count, torque_Nm, v_bus_V, temperature_degC;
    plant_counts_t held[PLANT_SETS];
    double late[PLANT_LEGS]; ///< duties of the previous call
} inject_t;

/// `bit`: INJECT_ANY_BIT at first.
void inject_init(inject_t *self, const inject_kind_t *kind, inject_place_t place,
                 const rig_config_t *config, const plant_config_t *plant, uint64_t seed);

/// One period of a rig with the fault. `truth`: at the start of the period.
void inject_step(inject_t *self, rig_t *rig, plant_truth_t *truth);

#endif
