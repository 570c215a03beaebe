/// Of board.c, beside what board.h asks for.
#ifndef EMULATOR_EMULATOR_H
#define EMULATOR_EMULATOR_H

/// One period shall take longer than two periods last. Before the periods start.
void emulator_overlong(void);

#endif
