/// Faults of a drive's hardware and memory, put in between its step and the plant.
#ifndef RIG_INJECT_H
#define RIG_INJECT_H

#include "rig/rig.h"

typedef enum {
    INJECT_NOTHING,      ///< the comparison
    INJECT_FREEZE,       ///< all current ADC channels keep their last count
    INJECT_HOLD,         ///< one keeps its last count
    INJECT_COUNT,        ///< one, or all, read `value` of full scale
    INJECT_FREEZE_NOISY, ///< as INJECT_FREEZE, with a count of noise
    INJECT_COUNT_NOISY,  ///< as INJECT_COUNT
    INJECT_GAIN,         ///< one, or all, read `value` times the current
    INJECT_OFFSET,       ///< one, or all, drift by `value` of i_max within 0.1 s
    INJECT_SWAP,         ///< the sensors of two phases are swapped
    INJECT_ROTATE,       ///< those of all three, in a ring
    INJECT_DEAD,      ///< the high (1) or low (0) switch of phase a no longer turns on; 2: neither
    INJECT_SHORT,     ///< it is shorted
    INJECT_OPEN,      ///< phase a breaks
    INJECT_LATE,      ///< duties act one period late
    INJECT_EARLY,     ///< one period early
    INJECT_REGISTER,  ///< the duty of phase a stays as it was (< 0), or at `value`
    INJECT_BUS_HOLD,  ///< the bus reads as it was while it moves by `value` of itself within 50 ms
    INJECT_BUS_READ,  ///< it reads `value` of full scale
    INJECT_NTC_HOLD,  ///< the temperature reads as it was while the power stage heats up
    INJECT_NTC_READ,  ///< it reads `value` of full scale
    INJECT_MISS,      ///< `value` interrupts in a row are missed
    INJECT_MISS_EACH, ///< one of `value`
    INJECT_DOUBLE,    ///< one interrupt comes twice
    INJECT_DOUBLE_EACH, ///< one of `value`
    INJECT_FLUX,        ///< the magnets keep `value` of their flux
    INJECT_JAM,         ///< the rotor stands
    INJECT_OVERHAUL,    ///< the load turns the rotor with `value` times the torque of i_max
    INJECT_FLIP_TUNING, ///< a bit of the tuning flips
    INJECT_FLIP_STATE,  ///< a bit of the drive's state
    INJECT_FLIP_MODE,   ///< a bit of the mode
    INJECT_FLIP_COMMAND ///< a bit of the command that is followed
} inject_how_t;

typedef struct {
    const char *name;
    const char *what; ///< in words
    int how;          ///< inject_how_t: each place looks at a few of them
    bool all;         ///< of all phases, not of phase a alone
    double value;
} inject_kind_t;

enum { INJECT_KINDS_MAX = 64 };

/// All kinds of fault, and how many.
extern const inject_kind_t inject_kinds[];
extern const int inject_kind_count;

/// A bit of memory: there is more than one such fault of a kind.
bool inject_is_random(const inject_kind_t *kind);

typedef struct {
    const inject_kind_t *kind;
    uint64_t seed;
    uint64_t periods; ///< since it began
    double ts_s, i_max_A, i_A_per_count, full_count, torque_Nm, v_bus_V, temperature_degC;
    plant_counts_t held[PLANT_SETS];
    double late[PLANT_LEGS]; ///< duties of the call before
} inject_t;

void inject_init(inject_t *self, const inject_kind_t *kind, const rig_config_t *config,
                 const plant_config_t *plant, uint64_t seed);

/// One period of a rig with the fault. `truth` is that of its beginning.
void inject_step(inject_t *self, rig_t *rig, plant_truth_t *truth);

#endif
