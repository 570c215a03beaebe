#include "lodestar/lowpass.h"

float lode_lowpass_weight(float tau_s, float ts_s) {
    return tau_s > 0.0f ? lode_one_minus_exp(ts_s / tau_s) : 1.0f;
}
