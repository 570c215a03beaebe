/// An HTML page around a picture, without scripts and without external resources.
#ifndef RIG_PAGE_H
#define RIG_PAGE_H

#include <stdio.h>

/// `svg`: the output of gnuplot, read from its beginning. `text`: the table below the picture, as on the
/// screen; NULL: none.
void page_write(FILE *page, const char *title, FILE *svg, const char *text);

#endif
