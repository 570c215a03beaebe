/* The part of <math.h> that the core may use, for compilers that come without a C library. */
#ifndef MATH_H
#define MATH_H

float sqrtf(float x);
float fabsf(float x);

#endif
