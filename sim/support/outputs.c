#include "support/outputs.h"

#include <errno.h>
#include <string.h>
#include <sys/stat.h>

#include "support/atomic_file.h"
#include "support/diag.h"

bool outputs_open(FILE **file, const char *path) {
    *file = NULL;
    if (path == NULL) {
        return true;
    }
    *file = atomic_file_open(path);
    return *file != NULL;
}

bool outputs_folder(const char *path) {
    if (mkdir(path, 0777) != 0 && errno != EEXIST) {
        rig_error("%s: %s; expected a folder that can be created", path, strerror(errno));
        return false;
    }
    return true;
}

void outputs_say(const char *path) {
    if (path != NULL) {
        (void)printf("written: %s\n", path);
    }
}
