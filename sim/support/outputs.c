#include "support/outputs.h"

#include "support/atomic_file.h"

bool outputs_open(FILE **file, const char *path) {
    *file = NULL;
    if (path == NULL) {
        return true;
    }
    *file = atomic_file_open(path);
    return *file != NULL;
}

void outputs_say(const char *path) {
    if (path != NULL) {
        (void)printf("written: %s\n", path);
    }
}
