/// Functions of board.c in addition to those of board.h.
#ifndef EMULATOR_EMULATOR_H
#define EMULATOR_EMULATOR_H

/// Makes one period take longer than two period lengths. Call before the periods start.
void emulator_overlong(void);

#endif
