// The page's code as firmware has it.
#include "board.h"

#include COUNTER
#include "collect.h"
