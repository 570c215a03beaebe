/// A page of HTML around a picture: no script, nothing that it fetches from elsewhere.
#ifndef RIG_PAGE_H
#define RIG_PAGE_H

#include <stdio.h>

/// `svg`: as gnuplot has written it, read from its beginning. `text`: table below it, as it stands on a
/// screen; NULL: none.
void page_write(FILE *page, const char *title, FILE *svg, const char *text);

#endif
