/// Messages to the user, on stderr, and the exit codes.
#ifndef RIG_DIAG_H
#define RIG_DIAG_H

#if defined(__GNUC__)
#define RIG_PRINTF(text, first) __attribute__((format(printf, text, first)))
#else
#define RIG_PRINTF(text, first)
#endif

typedef enum {
    RIG_DONE = 0, ///< done
    RIG_FAILED =
        1, ///< drive faulted, missed a bar, refused a command or never ran; decoded file damaged
    RIG_BAD_INPUT = 2 ///< the command line or a file is not usable
} rig_exit_t;

/// "lodestar: ..."
void rig_error(const char *format, ...) RIG_PRINTF(1, 2);

/// "FILE:LINE: ..."; line 0: "FILE: ..."
void rig_error_at(const char *file, int line, const char *format, ...) RIG_PRINTF(3, 4);

#endif
