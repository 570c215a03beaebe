/// Panels in rows and columns for the figures of a reproduction, column by column.
#ifndef RIG_REPRODUCE_PANELS_H
#define RIG_REPRODUCE_PANELS_H

#include <stdbool.h>
#include <stdio.h>

/// Height of a picture, pixels.
int panels_height(int rows);

/// Starts them, with names of four colours: blue, red, green, grey.
void panels_begin(FILE *script, const char *title, int rows, int columns);

/// An angle in degrees; NaN if it has wrapped since the previous point, so that the line breaks.
double panels_angle_deg(double angle_rad, double before_rad);

/// Starts the next panel. `title`: of its column, "" below the first row; `last`: in its column.
void panels_next(FILE *script, const char *label, const char *title, bool last);

#endif
