#include "lodestar/channel.h"

#include "inverter_inline.h"
#include "sense_inline.h"

#include <stddef.h>

// The voltage that the next period assumes to have acted, as lode_drive_sense() will compute it.
static inline lode_ab_t seen_V(const lode_drive_t *drive) {
    if (!drive->gates) {
        return (lode_ab_t){0.0f, 0.0f};
    }
    return lode_inverter_less_drop(&drive->inverter,
                                   lode_inverter_realised(&drive->inverter, drive->steps),
                                   drive->estimator.emf.i_A);
}

// Channels of starts, faults, limits and heat: rare, so not LODE_RAMFUNC. 0 for any other number.
static LODE_NOINLINE float rare_value(const lode_drive_t *drive, lode_channel_t channel) {
    const lode_fault_t *fault = &drive->guard.fault;
    if (channel == LODE_CHANNEL_TEMPERATURE) {
        return lode_sense_temperature_degC(&drive->tuning->sense, drive->temperature);
    }
    if (channel == LODE_CHANNEL_FAULT_MEASURED) {
        return fault->measured;
    }
    if (channel == LODE_CHANNEL_FAULT_LIMIT) {
        return fault->limit;
    }
    if (channel == LODE_CHANNEL_START_STAGE) {
        return (float)lode_drive_start_stage(drive);
    }
    if (channel == LODE_CHANNEL_RETRIES) {
        return (float)lode_drive_retries(drive);
    }
    if (channel == LODE_CHANNEL_SIGNALS_CHECKED) {
        return lode_drive_knows(drive, LODE_KNOWN_SIGNALS) ? 1.0f : 0.0f;
    }
    if (channel == LODE_CHANNEL_LIMITED) {
        return (float)lode_drive_limited(drive);
    }
    return channel == LODE_CHANNEL_CRITERION ? (float)fault->criterion : 0.0f;
}

// The one place that knows where a drive keeps its quantities.
static inline float value_of(const lode_drive_t *drive, lode_channel_t channel) {
    switch (channel) {
    case LODE_CHANNEL_MODE:
        return (float)drive->mode;
    case LODE_CHANNEL_CHECK:
        return (float)drive->guard.fault.check;
    case LODE_CHANNEL_DUTY_A:
        return drive->duty.a;
    case LODE_CHANNEL_DUTY_B:
        return drive->duty.b;
    case LODE_CHANNEL_DUTY_C:
        return drive->duty.c;
    case LODE_CHANNEL_ID:
        return drive->i_A.d;
    case LODE_CHANNEL_IQ:
        return drive->i_A.q;
    case LODE_CHANNEL_ID_REF:
        return drive->ref_A.d;
    case LODE_CHANNEL_IQ_REF:
        return drive->ref_A.q;
    case LODE_CHANNEL_UD:
        return drive->u_V.d;
    case LODE_CHANNEL_UQ:
        return drive->u_V.q;
    case LODE_CHANNEL_V_BUS:
        return drive->inverter.v_bus_V;
    case LODE_CHANNEL_THETA:
        return lode_estimator_theta_rad(&drive->estimator);
    case LODE_CHANNEL_OMEGA:
        return drive->estimator.pll.omega_rad_s;
    case LODE_CHANNEL_SPEED_REF:
        return lode_drive_speed_ref_rad_s(drive);
    case LODE_CHANNEL_LOAD_TORQUE:
        return drive->tuning->estimator.load_per_f_Nm * drive->estimator.pll.f_rad_s2;
    case LODE_CHANNEL_LOCK:
        return drive->estimator.lock;
    case LODE_CHANNEL_E_ALPHA:
        return drive->estimator.emf.observer.e_V.alpha;
    case LODE_CHANNEL_E_BETA:
        return drive->estimator.emf.observer.e_V.beta;
    case LODE_CHANNEL_I_ALPHA:
        return drive->estimator.emf.i_A.alpha;
    case LODE_CHANNEL_I_BETA:
        return drive->estimator.emf.i_A.beta;
    case LODE_CHANNEL_U_ALPHA:
        return seen_V(drive).alpha;
    case LODE_CHANNEL_U_BETA:
        return seen_V(drive).beta;
    case LODE_CHANNEL_TEMPERATURE:
    case LODE_CHANNEL_FAULT_MEASURED:
    case LODE_CHANNEL_FAULT_LIMIT:
    case LODE_CHANNEL_START_STAGE:
    case LODE_CHANNEL_RETRIES:
    case LODE_CHANNEL_CRITERION:
    case LODE_CHANNEL_SIGNALS_CHECKED:
    case LODE_CHANNEL_LIMITED:
    case LODE_CHANNEL_COUNT:
    default:
        return rare_value(drive, channel);
    }
}

LODE_RAMFUNC float lode_channel_read(const lode_drive_t *drive, lode_channel_t channel) {
    return value_of(drive, channel);
}

LODE_RAMFUNC uint32_t lode_channel_bits(float value) {
    const union {
        float value;
        uint32_t bits;
    } same = {value};
    return same.bits;
}

lode_status_t lode_channels_init(lode_channels_t *self, const lode_channels_config_t *config) {
    if (self == NULL || config == NULL) {
        return LODE_ERROR_NULL;
    }
    if (!lode_in_range(config->f_pwm_Hz, 1.0e3f, 2.0e5f)) {
        return LODE_ERROR_F_PWM;
    }
    if (config->count < 1u || config->count > (uint16_t)LODE_CHANNELS_MAX) {
        return LODE_ERROR_CHANNELS;
    }
    lode_channels_t channels = {.count = config->count};
    channels.decimation = config->decimation > 0u ? config->decimation : 1u;
    for (uint16_t n = 0u; n < config->count; n++) {
        if ((uint32_t)config->channel[n] >= (uint32_t)LODE_CHANNEL_COUNT) {
            return LODE_ERROR_CHANNELS;
        }
        channels.channel[n] = (uint_least8_t)config->channel[n];
    }
    *self = channels;
    return LODE_OK;
}

LODE_RAMFUNC void lode_channels_row(const lode_channels_t *self, const lode_drive_t *drive,
                                    uint32_t *row) {
    for (uint16_t n = 0u; n < self->count; n++) {
        row[n] = lode_channel_bits(value_of(drive, (lode_channel_t)self->channel[n]));
    }
}
