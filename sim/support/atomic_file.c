#include "support/atomic_file.h"

#include "support/diag.h"
#include "support/inputs.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define TWICE "another output of this command has this name"

enum { FILES_MAX = 64, NAME_MAX_LENGTH = 4096 };

typedef struct {
    FILE *file; ///< NULL: free
    char target[NAME_MAX_LENGTH];
    char temporary[NAME_MAX_LENGTH];
} output_t;

// One per process, because a signal handler has no other access to it.
static output_t outputs[FILES_MAX];

static void end_process(int number) {
    for (int k = 0; k < FILES_MAX; ++k) {
        if (outputs[k].temporary[0] != '\0') {
            (void)unlink(outputs[k].temporary);
        }
    }
    _exit(128 + number);
}

static void watched_signals(sigset_t *set) {
    (void)sigemptyset(set);
    (void)sigaddset(set, SIGINT);
    (void)sigaddset(set, SIGTERM);
    (void)sigaddset(set, SIGHUP);
    (void)sigaddset(set, SIGPIPE);
}

static void watch(int number) {
    struct sigaction action = {.sa_handler = end_process};
    struct sigaction before;
    watched_signals(&action.sa_mask);
    // Signals that the parent process has switched off (nohup) stay off.
    if (sigaction(number, NULL, &before) == 0 && before.sa_handler != SIG_IGN) {
        (void)sigaction(number, &action, NULL);
    }
}

void atomic_file_catch_signals(void) {
    watch(SIGINT);
    watch(SIGTERM);
    watch(SIGHUP);
    watch(SIGPIPE);
}

static output_t *free_slot(void) {
    for (int k = 0; k < FILES_MAX; ++k) {
        if (outputs[k].file == NULL) {
            return &outputs[k];
        }
    }
    return NULL;
}

static FILE *refuse(output_t *output, const char *path, const char *why) {
    output->temporary[0] = '\0';
    rig_error("%s: cannot write: %s; expected a path in a folder that may be written to", path,
              why);
    return NULL;
}

/// The same for a file that this command itself needs.
static FILE *refuse_own(const char *path, const char *why) {
    rig_error("%s: cannot write: %s; expected a separate file for each output", path, why);
    return NULL;
}

/// True if this is the file of another output.
static bool is_output(const struct stat *about) {
    for (int k = 0; k < FILES_MAX; ++k) {
        struct stat other;
        if (outputs[k].file != NULL && outputs[k].temporary[0] != '\0' &&
            stat(outputs[k].target, &other) == 0 && other.st_dev == about->st_dev &&
            other.st_ino == about->st_ino) {
            return true;
        }
    }
    return false;
}

/// Why an existing file must not be replaced: this command reads it or already writes it. NULL if it may be.
static const char *own_use(const struct stat *about) {
    // A terminal may be both read and written.
    if (!S_ISCHR(about->st_mode) && inputs_include(about)) {
        return "it is an input of this command";
    }
    return is_output(about) ? TWICE : NULL;
}

static FILE *open_directly(output_t *output, const char *path) {
    output->file = fopen(path, "w");
    output->temporary[0] = '\0';
    (void)snprintf(output->target, sizeof output->target, "%s", path);
    return output->file != NULL ? output->file : refuse(output, path, strerror(errno));
}

/// Follows a link, so that the file it points to is replaced and not the link.
static bool name_files(output_t *output, const char *path) {
    char *real = realpath(path, NULL);
    const char *target = real != NULL ? real : path;
    const char *slash = strrchr(target, '/');
    const int folder = slash == NULL ? 0 : (int)(slash - target) + 1;
    const size_t size = NAME_MAX_LENGTH;
    const int length = snprintf(output->temporary, size, "%.*s.%s.%ld.tmp", folder, target,
                                target + folder, (long)getpid());
    (void)snprintf(output->target, size, "%s", target);
    free(real);
    return length >= 0 && (size_t)length < size;
}

FILE *atomic_file_open(const char *path) {
    output_t *output = free_slot();
    if (output == NULL) {
        rig_error("%s: too many output files", path);
        return NULL;
    }
    if (path[0] == '\0') {
        return refuse(output, path, "the name is empty");
    }
    struct stat about;
    if (stat(path, &about) == 0) {
        const char *why = own_use(&about);
        if (S_ISDIR(about.st_mode)) {
            return refuse(output, path, "it is a folder");
        }
        if (why != NULL) {
            return refuse_own(path, why);
        }
        if (!S_ISREG(about.st_mode)) {
            return open_directly(output, path);
        }
    }
    if (!name_files(output, path)) {
        return refuse(output, path, "the name is too long");
    }
    const int handle = open(output->temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (handle < 0) {
        const int error = errno;
        output->temporary[0] = '\0'; // it belongs to another output
        return error == EEXIST ? refuse_own(path, TWICE) : refuse(output, path, strerror(error));
    }
    output->file = fdopen(handle, "w");
    return output->file;
}

/// False after a message if the file was not written completely.
static bool finish(output_t *output) {
    const bool written = fflush(output->file) == 0 && ferror(output->file) == 0;
    const bool closed = fclose(output->file) == 0;
    output->file = NULL;
    if (written && closed) {
        return true;
    }
    rig_error("%s: cannot write: %s; expected room for the whole file", output->target,
              strerror(errno));
    return false;
}

static bool give_name(output_t *output) {
    if (output->temporary[0] == '\0') {
        return true;
    }
    const bool named = rename(output->temporary, output->target) == 0;
    if (!named) {
        rig_error("%s: cannot write: %s", output->target, strerror(errno));
        (void)unlink(output->temporary);
    }
    output->temporary[0] = '\0';
    return named;
}

bool atomic_file_commit_all(void) {
    bool good = true;
    for (int k = 0; k < FILES_MAX; ++k) {
        good = (outputs[k].file == NULL || finish(&outputs[k])) && good;
    }
    if (!good) {
        atomic_file_discard_all();
        return false;
    }
    // A signal comes before all of the renames or after them.
    sigset_t watched;
    sigset_t before;
    watched_signals(&watched);
    (void)sigprocmask(SIG_BLOCK, &watched, &before);
    for (int k = 0; k < FILES_MAX; ++k) {
        good = give_name(&outputs[k]) && good;
    }
    (void)sigprocmask(SIG_SETMASK, &before, NULL);
    return good;
}

void atomic_file_discard_all(void) {
    for (int k = 0; k < FILES_MAX; ++k) {
        if (outputs[k].file != NULL) {
            (void)fclose(outputs[k].file);
            outputs[k].file = NULL;
        }
        if (outputs[k].temporary[0] != '\0') {
            (void)unlink(outputs[k].temporary);
            outputs[k].temporary[0] = '\0';
        }
    }
}
