#include "support/workers.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

#include "support/diag.h"

typedef struct {
    unsigned count;
    pid_t process[WORKERS_MAX];
    int from[WORKERS_MAX]; ///< reading end of the pipe of each worker
} crew_t;

/// One message: a mark that says whether there is a result, then the result.
typedef struct {
    bool good;
    unsigned char result[WORKERS_RESULT_MAX];
} message_t;

static unsigned processes_wanted(const workers_t *self) {
    const long online = sysconf(_SC_NPROCESSORS_ONLN);
    const unsigned most = self->last - self->first < WORKERS_MAX
                              ? (unsigned)(self->last - self->first) + 1u
                              : WORKERS_MAX;
    const unsigned wanted = self->processes > 0u ? self->processes
                            : online > 0         ? (unsigned)online
                                                 : 1u;
    return wanted < most ? wanted : most;
}

static bool send_all(int to, const message_t *message) {
    const char *from = (const char *)message;
    size_t left = sizeof *message;
    while (left > 0u) {
        const ssize_t sent = write(to, from, left);
        if (sent < 0 && errno != EINTR) {
            return false;
        }
        from += sent > 0 ? sent : 0;
        left -= sent > 0 ? (size_t)sent : 0u;
    }
    return true;
}

static bool receive_all(int from, message_t *message) {
    char *to = (char *)message;
    size_t left = sizeof *message;
    while (left > 0u) {
        const ssize_t got = read(from, to, left);
        if (got == 0 || (got < 0 && errno != EINTR)) {
            return false;
        }
        to += got > 0 ? got : 0;
        left -= got > 0 ? (size_t)got : 0u;
    }
    return true;
}

/// Body of a worker. Signals end it at once; the parent removes unfinished files. Work that it cannot do is
/// repeated by the parent, which then reports the error once.
static void live(const workers_t *self, unsigned index, unsigned count, int to) {
    static const int watched[] = {SIGINT, SIGTERM, SIGHUP, SIGPIPE};
    for (size_t k = 0; k < sizeof watched / sizeof watched[0]; ++k) {
        (void)signal(watched[k], SIG_DFL);
    }
    const int nowhere = open("/dev/null", O_WRONLY);
    (void)dup2(nowhere, STDERR_FILENO);
    message_t message = {.good = true};
    for (uint64_t n = self->first + index; message.good && n <= self->last; n += count) {
        message.good = self->work(self->user, n, message.result);
        if (!send_all(to, &message)) {
            break;
        }
    }
    _exit(0);
}

/// False if the system has no more pipes or processes.
static bool hire(const workers_t *self, crew_t *crew, unsigned count) {
    for (unsigned k = 0; k < count; ++k) {
        int ends[2];
        if (pipe(ends) != 0) {
            return false;
        }
        const pid_t process = fork();
        if (process == 0) {
            for (unsigned n = 0; n < crew->count; ++n) {
                (void)close(crew->from[n]);
            }
            (void)close(ends[0]);
            live(self, k, count, ends[1]);
        }
        (void)close(ends[1]);
        if (process < 0) {
            (void)close(ends[0]);
            return false;
        }
        crew->from[crew->count] = ends[0];
        crew->process[crew->count++] = process;
    }
    return true;
}

static void dismiss(const crew_t *crew) {
    for (unsigned k = 0; k < crew->count; ++k) {
        (void)close(crew->from[k]);
        (void)kill(crew->process[k], SIGTERM);
    }
    for (unsigned k = 0; k < crew->count; ++k) {
        (void)waitpid(crew->process[k], NULL, 0);
    }
}

static bool gather(const workers_t *self, const crew_t *crew) {
    for (uint64_t n = self->first; crew->count > 0u && n <= self->last; ++n) {
        message_t message;
        if (!receive_all(crew->from[(n - self->first) % crew->count], &message)) {
            rig_error("a worker process ended unexpectedly");
            return false;
        }
        // Work that a worker could not do fails here in the same way, with its message.
        if (!message.good && !self->work(self->user, n, message.result)) {
            return false;
        }
        self->take(self->user, n, message.result);
    }
    return true;
}

bool workers_run(const workers_t *self) {
    crew_t crew = {.count = 0u};
    (void)fflush(NULL);
    bool good = hire(self, &crew, processes_wanted(self));
    if (!good) {
        rig_error("cannot start another process: %s; expected --jobs N with a smaller N",
                  strerror(errno));
    }
    good = good && gather(self, &crew);
    dismiss(&crew);
    return good;
}
