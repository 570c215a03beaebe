/// The LaunchPad with what it does not have: sensors in the phases, in place of its shunts, and so two calls in a
/// period.
#include "boards/launchxl_f280049c_drv8320rs.h"

#ifndef VARIANT_SENSING // or still the shunts, which is refused
#define VARIANT_SENSING PORT_IN_LINE_THREE
#endif
#define VARIANT_DOUBLE_UPDATE true
