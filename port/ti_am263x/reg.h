/// Every access of the AM263x port to a register goes by address through these functions. The tests replace
/// them, to record the order.
#ifndef LODESTAR_PORT_TI_AM263X_REG_H
#define LODESTAR_PORT_TI_AM263X_REG_H

#include <stdbool.h>
#include <stdint.h>

#ifndef TI_REG_H
#define TI_REG_H "access.h"
#endif
#include TI_REG_H

#endif
