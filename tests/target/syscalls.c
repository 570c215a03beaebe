/// What newlib asks of a system: output by semihosting, a heap between data and stack, nothing else.
#include <errno.h>
#include <stddef.h>
#include <sys/stat.h>

#include "semihost.h"

/// Of the linker script.
extern char heap_begin[], heap_end[];

int _write(int file, const char *data, int length);
void *_sbrk(ptrdiff_t increment);
int _close(int file);
int _fstat(int file, struct stat *status);
int _isatty(int file);
int _lseek(int file, int offset, int origin);
int _read(int file, char *data, int length);
int _kill(int process, int signal);
int _getpid(void);

int _write(int file, const char *data, int length) {
    (void)file;
    char text[65];
    int used = 0;
    for (int n = 0; n < length; n++) {
        text[used++] = data[n];
        if (used == (int)sizeof text - 1 || n == length - 1) {
            text[used] = '\0';
            semihost_print(text);
            used = 0;
        }
    }
    return length;
}

void *_sbrk(ptrdiff_t increment) {
    static char *end = heap_begin;
    if (increment > heap_end - end) {
        errno = ENOMEM;
        return (void *)-1;
    }
    char *const block = end;
    end += increment;
    return block;
}

int _close(int file) {
    (void)file;
    return -1;
}

int _fstat(int file, struct stat *status) {
    (void)file;
    status->st_mode = S_IFCHR;
    return 0;
}

int _isatty(int file) {
    (void)file;
    return 1;
}

int _lseek(int file, int offset, int origin) {
    (void)file;
    (void)offset;
    (void)origin;
    return 0;
}

int _read(int file, char *data, int length) {
    (void)file;
    (void)data;
    (void)length;
    return 0;
}

int _kill(int process, int signal) {
    (void)process;
    (void)signal;
    return -1;
}

int _getpid(void) {
    return 1;
}
