/// Lodestar: sensorless permanent-magnet motor drives. Includes everything.
#ifndef LODESTAR_LODESTAR_H
#define LODESTAR_LODESTAR_H

#include "lodestar/adaptation.h"
#include "lodestar/adaptation6.h"
#include "lodestar/chopper.h"
#include "lodestar/commission.h"
#include "lodestar/commission6.h"
#include "lodestar/derate.h"
#include "lodestar/drive.h"
#include "lodestar/drive6.h"
#include "lodestar/encoder.h"
#include "lodestar/fault_log.h"
#include "lodestar/learn.h"
#include "lodestar/ring.h"
#include "lodestar/scope.h"
#include "lodestar/single_shunt.h"
#include "lodestar/sogi.h"
#include "lodestar/supervisor.h"
#include "lodestar/supply.h"
#include "lodestar/version.h"

#endif
