/// board_describe() for every board with a header of values (VARIANT_...) and a chip.h.
#include "board.h"
#include "chip.h"

#include "calls.h"
#include "figures.h"
#include "ntc.h"

#ifndef VARIANT_SENSING
#define VARIANT_SENSING PORT_LOW_SIDE_THREE
#endif
#ifndef VARIANT_LOW_SIDES // default: the chip can switch the low sides alone
#define VARIANT_LOW_SIDES true
#endif
#ifndef VARIANT_PRECHARGE_s // no bootstrap capacitors
#define VARIANT_PRECHARGE_s 0.0f
#endif
#ifndef CHIP_LEAD_ns // the first current is sampled this long before t_k
#define CHIP_LEAD_ns 0.0f
#endif

void board_describe(lode_drive_config_t *config) {
    const float f_call_Hz = (float)PORT_F_CALL_Hz;
    config->f_pwm_Hz = f_call_Hz;
    config->inverter = (lode_inverter_config_t){
        .v_bus_V = VARIANT_V_BUS_V,
        .i_max_A = VARIANT_I_MAX_A,
        .dead_time_s = (float)VARIANT_DEAD_TIME_ns * 1.0e-9f,
        .v_drop_V = VARIANT_V_DROP_V,
        .r_on_Ohm = VARIANT_R_ON_Ohm,
        .precharge_s = VARIANT_PRECHARGE_s,
        .pwm_ticks = (float)port_pwm_steps(CHIP_F_PWM_Hz, VARIANT_F_PWM_Hz),
        .double_update = VARIANT_DOUBLE_UPDATE ? LODE_ON : LODE_OFF,
    };
    config->sense = (lode_sense_config_t){
        .i_gain_A_count = VARIANT_I_GAIN_A_count,
        .i_offset_count = VARIANT_I_OFFSET_count,
        .i_offset_tol_count = VARIANT_I_OFFSET_TOL_count,
        .v_bus_gain_V_count = VARIANT_V_BUS_GAIN_V_count,
        .temperature_gain_degC_count = VARIANT_T_GAIN_degC_count,
        .temperature_offset_degC = VARIANT_T_OFFSET_degC,
    };
    config->guard.temperature_max_degC = VARIANT_T_MAX_degC;
    port_sensing(config, VARIANT_SENSING, VARIANT_SETTLE_ns + CHIP_LEAD_ns, CHIP_SAMPLE_ns);
    if (!VARIANT_LOW_SIDES) {
        config->start.pulses = LODE_OFF;
    }
    config->guard.stamp_per_period = (float)CHIP_F_STAMP_Hz / f_call_Hz;
}
