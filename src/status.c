#include "lodestar/status.h"

// One row per enumerator: the compiler's -Wswitch finds a missing one.
#define NAME(status)                                                                               \
    case status:                                                                                   \
        return #status

// A table in the form of a switch. NOLINTNEXTLINE(readability-function-size)
const char *lode_status_name(lode_status_t status) {
    switch (status) {
        NAME(LODE_OK);
        NAME(LODE_ERROR_NULL);
        NAME(LODE_ERROR_F_PWM);
        NAME(LODE_ERROR_MOTOR_POLE_PAIRS);
        NAME(LODE_ERROR_MOTOR_RS);
        NAME(LODE_ERROR_MOTOR_LD);
        NAME(LODE_ERROR_MOTOR_LQ);
        NAME(LODE_ERROR_MOTOR_PSI);
        NAME(LODE_ERROR_MOTOR_J);
        NAME(LODE_ERROR_MOTOR_B);
        NAME(LODE_ERROR_MOTOR_OMEGA);
        NAME(LODE_ERROR_MOTOR_PERIOD);
        NAME(LODE_ERROR_V_BUS);
        NAME(LODE_ERROR_I_MAX);
        NAME(LODE_ERROR_DEAD_TIME);
        NAME(LODE_ERROR_V_DROP);
        NAME(LODE_ERROR_R_ON);
        NAME(LODE_ERROR_I_DEAD);
        NAME(LODE_ERROR_PWM_TICKS);
        NAME(LODE_ERROR_SENSE_SHUNTS);
        NAME(LODE_ERROR_SENSE_CURRENT);
        NAME(LODE_ERROR_SENSE_BUS);
        NAME(LODE_ERROR_SENSE_TEMPERATURE);
        NAME(LODE_ERROR_SENSE_OFFSET);
        NAME(LODE_ERROR_SENSE_WINDOW);
        NAME(LODE_ERROR_SENSE_CALIBRATION);
        NAME(LODE_ERROR_EMF_KIND);
        NAME(LODE_ERROR_EMF_GI);
        NAME(LODE_ERROR_EMF_FA);
        NAME(LODE_ERROR_EMF_W0);
        NAME(LODE_ERROR_PLL_KIND);
        NAME(LODE_ERROR_PLL_SIGMA);
        NAME(LODE_ERROR_PLL_OBSERVER);
        NAME(LODE_ERROR_NOTCH);
        NAME(LODE_ERROR_EMF_PLL);
        NAME(LODE_ERROR_W_FILTER);
        NAME(LODE_ERROR_PLL_SCHEDULE);
        NAME(LODE_ERROR_LAG);
        NAME(LODE_ERROR_EMIN);
        NAME(LODE_ERROR_OMEGA_MAX);
        NAME(LODE_ERROR_CHOICE);
        NAME(LODE_ERROR_LOCK_TIME);
        NAME(LODE_ERROR_CURRENT_BANDWIDTH);
        NAME(LODE_ERROR_CURRENT_GAINS);
        NAME(LODE_ERROR_CURRENT_VOLTAGE);
        NAME(LODE_ERROR_SPEED_GAINS);
        NAME(LODE_ERROR_SPEED_BANDWIDTH);
        NAME(LODE_ERROR_SPEED_RAMP);
        NAME(LODE_ERROR_SPEED_FEED_FORWARD);
        NAME(LODE_ERROR_ID_BIAS);
        NAME(LODE_ERROR_REFERENCES);
        NAME(LODE_ERROR_FIELD_WEAKENING);
        NAME(LODE_ERROR_LQ_FALL);
        NAME(LODE_ERROR_BUS_FADE);
        NAME(LODE_ERROR_START_CURRENT);
        NAME(LODE_ERROR_START_SPEED);
        NAME(LODE_ERROR_START_RAMP);
        NAME(LODE_ERROR_START_DAMPING);
        NAME(LODE_ERROR_GUARD_CURRENT);
        NAME(LODE_ERROR_GUARD_BUS);
        NAME(LODE_ERROR_GUARD_TEMPERATURE);
        NAME(LODE_ERROR_GUARD_SPEED);
        NAME(LODE_ERROR_GUARD_TIME);
        NAME(LODE_ERROR_COMMAND);
        NAME(LODE_ERROR_CHANNELS);
        NAME(LODE_ERROR_BUFFER);
        NAME(LODE_ERROR_TRIGGER);
        NAME(LODE_ERROR_PRE_SHARE);
    case LODE_STATUS_COUNT:
    default:
        return "LODE_STATUS_UNKNOWN";
    }
}
