/// Pictures by gnuplot, which runs as a child process.
#ifndef RIG_PLOT_H
#define RIG_PLOT_H

#include <stdbool.h>
#include <stdio.h>

enum { PLOT_TEXT_LENGTH = 512 };

/// False after a message if gnuplot cannot be started.
bool plot_available(void);

/// A gnuplot under way: its commands go into `script`, its SVG into the file given.
typedef struct {
    FILE *script;
    long process;
} plot_t;

/// Starts gnuplot with its output in `svg`, `width` x `height` pixels. False after a message.
bool plot_start(plot_t *self, FILE *svg, int width, int height);

/// A text as a gnuplot string, quotes included, cut to what fits in `string`. Every text that is not
/// part of this program goes into a script by this only. Single quotes, in which gnuplot takes
/// nothing for a command, a variable or an escape, and none within: U+2019 stands for each (gnuplot
/// reads a pair at the start as an empty string). A blank for each control character and `?` for each
/// byte that is not UTF-8, which no picture could hold. Show it with `noenhanced`. Returns
/// `string`.
const char *plot_text(char string[PLOT_TEXT_LENGTH], const char *text);

/// Sets up `panels` panels one above the other over a common time axis, legends on their right, a
/// title over the first one (label 1000), and the names of four colours: blue, red, green, grey.
void plot_style(FILE *script, const char *title, int panels, double from_s, double to_s);

/// Names the vertical axis of the panels to come.
void plot_panel(FILE *script, const char *label);

/// Waits for it. False after a message if it failed.
bool plot_finish(plot_t *self);

#endif
