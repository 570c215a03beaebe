/// Included ahead of a module's test: RUN_TEST leaves out what takes too long where every double is
/// computed by an emulated processor without a unit for it. The host runs all of it.
#ifndef TARGET_LEFT_OUT_H
#define TARGET_LEFT_OUT_H

#include <unity.h>

#undef RUN_TEST
#define RUN_TEST(test) left_out_or_run((test), #test, __LINE__)

void left_out_or_run(void (*test)(void), const char *name, int line);

#endif
