#include "lodestar/single_shunt.h"

#define WINDOW_MAX 0.25f // of the period
// With halved zero vectors and a voltage vector between two legs of equal duty, both have the duty 1/2 + sqrt(3)/4 of its
// share of the circle.
#define TWO_LEGS 0.4330127f
#define THIRD (1.0f / 3.0f)
#define COUNT_MAX 65535.0f
// Beyond any board and motor.
#define GAIN_MAX 1.0e4f
#define L_MAX_H 10.0f

lode_status_t lode_single_shunt_tune(lode_single_shunt_tuning_t *tuning,
                                     const lode_single_shunt_config_t *config) {
    const float window = config->window_s * config->f_pwm_Hz;
    const float sample = config->sample_s * config->f_pwm_Hz;
    const float gain = config->i_gain_A_count;
    if (!lode_in_range(window, 0.0f, WINDOW_MAX) || !lode_in_range(sample, 0.0f, window)) {
        return LODE_ERROR_SENSE_WINDOW;
    }
    if (!(gain > 0.0f || gain < 0.0f) || !lode_in_range(gain, -GAIN_MAX, GAIN_MAX) ||
        !lode_in_range(config->L_H, 0.0f, L_MAX_H)) {
        return LODE_ERROR_SENSE_CURRENT;
    }
    const float volt_seconds = config->L_H > 0.0f ? 1.0f / (config->L_H * config->f_pwm_Hz) : 0.0f;
    *tuning = (lode_single_shunt_tuning_t){
        .window = 2.0f * window,
        .sample = sample,
        .rise_count_V = volt_seconds / gain,
    };
    return LODE_OK;
}

float lode_single_shunt_voltage_use(const lode_single_shunt_tuning_t *tuning) {
    return lode_min(LODE_VOLTAGE_USE, (0.5f - 0.5f * tuning->window) / TWO_LEGS);
}

void lode_single_shunt_reset(lode_single_shunt_t *self) {
    *self = (lode_single_shunt_t){.count = {0u}};
}

static float *part(lode_abc_t *x, uint_least8_t phase) {
    return phase == 0u ? &x->a : (phase == 1u ? &x->b : &x->c);
}

static float of(lode_abc_t x, uint_least8_t phase) {
    return *part(&x, phase);
}

// From the longest duty to the shortest.
static void sort(lode_abc_t duty, uint_least8_t order[3]) {
    const bool ab = duty.a >= duty.b;
    const bool bc = duty.b >= duty.c;
    const bool ac = duty.a >= duty.c;
    order[0] = ab && ac ? 0u : (bc ? 1u : 2u);
    order[2] = !ab && !ac ? 0u : (bc ? 2u : 1u);
    order[1] = (uint_least8_t)(3u - order[0] - order[2]);
}

// Puts a leg's falling edge at `fall`, as far as its duty allows; the rising edge keeps the duty.
static bool shift(lode_single_shunt_plan_t *plan, uint_least8_t phase, float duty, float fall) {
    const float made =
        lode_clamp(fall, lode_max(2.0f * duty - 1.0f, 0.0f), lode_min(2.0f * duty, 1.0f));
    *part(&plan->fall, phase) = made;
    *part(&plan->rise, phase) = 2.0f * duty - made;
    return lode_abs(made - fall) <= 0.0f;
}

// What a phase's voltage, less its mean over the period, adds to its current from a sample to t_k. EMF and resistive drop
// make up that mean, as long as the current hardly changes from period to period.
static void correct(lode_single_shunt_plan_t *plan, lode_abc_t duty, uint_least8_t middle) {
    const float end[2] = {0.5f * (1.0f + of(plan->fall, middle)),
                          0.5f * (1.0f + of(plan->fall, plan->most))};
    const float centre = THIRD * (duty.a + duty.b + duty.c);
    const float least = of(duty, plan->least) - centre;
    const float most = of(duty, plan->most) - centre;
    // With two legs high the third one has -2/3 of the bus; with one leg high this has 2/3, the others -1/3.
    plan->correction_V[0] = -2.0f * THIRD * (end[0] - plan->sample[0]) - THIRD * (end[1] - end[0]) -
                            least * (1.0f - plan->sample[0]);
    plan->correction_V[1] =
        2.0f * THIRD * (end[1] - plan->sample[1]) - most * (1.0f - plan->sample[1]);
}

static lode_single_shunt_plan_t plan_of(const lode_single_shunt_tuning_t *tuning, lode_abc_t duty) {
    const float window = tuning->window;
    uint_least8_t order[3];
    sort(duty, order);
    lode_single_shunt_plan_t plan = {.most = order[0], .least = order[2], .driven = true};
    const float middle = lode_clamp(of(duty, order[1]), window, 1.0f - window);
    const bool fits = shift(&plan, order[1], of(duty, order[1]), middle);
    const float most = lode_max(of(duty, order[0]), middle + window);
    const float least = lode_min(of(duty, order[2]), middle - window);
    const bool above = shift(&plan, order[0], of(duty, order[0]), most);
    const bool below = shift(&plan, order[2], of(duty, order[2]), least);
    plan.blind = !fits || !above || !below;
    // The last instant before the edge that ends each vector: the longest time to settle.
    plan.sample[0] = 0.5f * (1.0f + of(plan.fall, order[1])) - tuning->sample;
    plan.sample[1] = 0.5f * (1.0f + of(plan.fall, order[0])) - tuning->sample;
    correct(&plan, duty, order[1]);
    return plan;
}

static uint16_t to_count(float count) {
    const float rounded = lode_clamp(count, 0.0f, COUNT_MAX) + 0.5f;
    return (uint16_t)(int32_t)rounded;
}

void lode_single_shunt_read(lode_single_shunt_t *self, const lode_single_shunt_tuning_t *tuning,
                            const uint16_t link[2], int32_t offset, float v_bus_V,
                            uint16_t count[3]) {
    const lode_single_shunt_plan_t *plan = &self->plan[0];
    if (!plan->driven) {
        self->count[0] = self->count[1] = self->count[2] = link[1];
    } else if (!plan->blind) {
        const float zero = (float)offset / (float)LODE_COUNT_FRACTION;
        const float per_V = tuning->rise_count_V * v_bus_V;
        const float least = zero - (float)link[0] + per_V * plan->correction_V[0];
        const float most = (float)link[1] - zero + per_V * plan->correction_V[1];
        self->count[plan->least] = to_count(zero + least);
        self->count[plan->most] = to_count(zero + most);
        self->count[3u - plan->least - plan->most] = to_count(zero - least - most);
    } else {
        // blind: keeps the previous counts
    }
    for (int32_t n = 0; n < LODE_PHASES; n++) {
        count[n] = self->count[n];
    }
}

lode_single_shunt_plan_t lode_single_shunt_write(lode_single_shunt_t *self,
                                                 const lode_single_shunt_tuning_t *tuning,
                                                 lode_abc_t duty, lode_gates_t gates) {
    self->plan[0] = self->plan[1];
    if (gates == LODE_GATES_ON) {
        self->plan[1] = plan_of(tuning, duty);
    } else { // the link shows no current: not even that of the low sides alone
        self->plan[0].driven = false;
        self->plan[1] = (lode_single_shunt_plan_t){
            .rise = duty, .fall = duty, .sample = {0.5f, 1.0f - tuning->sample}};
    }
    return self->plan[1];
}
