/// Pictures by gnuplot, which runs as a child process: SVG, PNG, or a self-contained HTML page.
#ifndef RIG_PLOT_H
#define RIG_PLOT_H

#include <stdbool.h>
#include <stdio.h>

enum { PLOT_TEXT_LENGTH = 512 };

/// False after a message if gnuplot cannot be started.
bool plot_available(void);

typedef enum { PLOT_SVG, PLOT_PNG, PLOT_HTML } plot_format_t;

/// Output of a picture.
typedef struct {
    FILE *file; ///< NULL: not wanted
    plot_format_t format;
    const char *text; ///< HTML: table below the picture
} plot_output_t;

/// Opens the file for `path` unless that is NULL. The extension of its name selects the format: .svg (or none),
/// .png, .html. False after a message.
bool plot_open(plot_output_t *self, const char *path);

/// Name of a picture in a folder: that of `file`, which ends in .svg, with the ending of `format` (svg, png,
/// html; NULL: svg) in its place.
void plot_path_in(char *path, size_t size, const char *folder, const char *file,
                  const char *format);

/// A running gnuplot; `script` takes its commands.
typedef struct {
    FILE *script;
    long process;
    const plot_output_t *output;
    const char *title;
    FILE *drawn; ///< the picture; when complete it is copied to the given file or its page
} plot_t;

/// Starts gnuplot with its output in `output`, `width` x `height` pixels. `title`: of a page. A NaN breaks the
/// line through its neighbours, as an empty line does. False after a message.
bool plot_start(plot_t *self, const plot_output_t *output, const char *title, int width,
                int height);

/// A text as a gnuplot string, quotes included, cut to the size of `string`. Every text that is not part of
/// this program must go into a script through this function. The string is in single quotes, in which gnuplot
/// interprets no commands, variables or escapes; U+2019 replaces a single quote in the text (gnuplot reads a
/// pair at the start as an empty string). A blank replaces each control character, and `?` each byte that is
/// not UTF-8. Show it with `noenhanced`. Returns `string`.
const char *plot_text(char string[PLOT_TEXT_LENGTH], const char *text);

/// Panels one above the other with a common time axis and legends on the right.
typedef struct {
    int width, height; ///< of the picture, pixels
    int top;           ///< above the panels
    int legend;        ///< right of the panels
    int panels;
    double from_s, to_s;
} plot_frame_t;

/// Sets them up, with a title over the first one (label 1000), and the names of four colours: blue, red,
/// green, grey.
void plot_style(FILE *script, const char *title, const plot_frame_t *frame);

/// Names the vertical axis of the next panel.
void plot_panel(FILE *script, const char *label);

/// Waits for gnuplot, and writes the picture or the page around it. False after a message if gnuplot failed or
/// drew an incomplete picture.
bool plot_finish(plot_t *self);

#endif
