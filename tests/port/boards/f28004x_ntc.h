/// The LaunchPad with what it does not have: an NTC on a free input, and drivers with bootstrap capacitors.
#include "boards/launchxl_f280049c_drv8320rs.h"

#undef VARIANT_T_GAIN_degC_count
#undef VARIANT_T_OFFSET_degC
#undef VARIANT_T_MAX_degC
#undef VARIANT_PRECHARGE_s
#define VARIANT_PRECHARGE_s 10.0e-3f
#define VARIANT_T_ADC ADCA_BASE
#define VARIANT_T_RESULT ADCARESULT_BASE
#define VARIANT_T_CHANNEL ADC_CH_ADCIN1
#define VARIANT_NTC_POINTS                                                                         \
    {0.0f, 28704.0f}, {25.0f, 10000.0f}, {50.0f, 4101.0f}, {100.0f, 987.0f}, {                     \
        150.0f, 333.0f                                                                             \
    }
#define VARIANT_NTC_FIXED_Ohm 10000.0f
#define VARIANT_NTC_TO_GROUND true
#define VARIANT_T_GAIN_degC_count PORT_NTC_GAIN_degC
#define VARIANT_T_OFFSET_degC PORT_NTC_ZERO_degC
#define VARIANT_T_MAX_degC 100.0f
