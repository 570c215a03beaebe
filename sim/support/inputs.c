#include "support/inputs.h"

#include <errno.h>
#include <unistd.h>

enum { INPUTS_MAX = 1024 };

typedef struct {
    dev_t device;
    ino_t number;
} input_t;

// One per process, like the outputs.
static input_t inputs[INPUTS_MAX];
static int count;

/// True for a device other than a terminal: its text may have no end.
static bool is_device(FILE *file, const struct stat *about) {
    return S_ISBLK(about->st_mode) || (S_ISCHR(about->st_mode) && isatty(fileno(file)) == 0);
}

FILE *inputs_open(const char *path) {
    struct stat about;
    FILE *file = fopen(path, "rb");
    if (file == NULL || fstat(fileno(file), &about) != 0) {
        return file;
    }
    if (is_device(file, &about)) {
        (void)fclose(file);
        errno = EINVAL;
        return NULL;
    }
    if (!inputs_include(&about)) {
        if (count == INPUTS_MAX) {
            (void)fclose(file);
            errno = ENFILE;
            return NULL;
        }
        inputs[count++] = (input_t){about.st_dev, about.st_ino};
    }
    return file;
}

bool inputs_include(const struct stat *about) {
    for (int k = 0; k < count; ++k) {
        if (inputs[k].device == about->st_dev && inputs[k].number == about->st_ino) {
            return true;
        }
    }
    return false;
}
