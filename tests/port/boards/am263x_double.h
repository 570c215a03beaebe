/// The example with sensors in the phases, in place of its shunts, and so two calls in a period.
#include "boards/generic_am263x.h"

#ifndef VARIANT_SENSING // or still the shunts, which is refused
#define VARIANT_SENSING PORT_IN_LINE_THREE
#endif
#define VARIANT_DOUBLE_UPDATE true
