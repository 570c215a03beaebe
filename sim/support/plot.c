#include "support/plot.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "support/diag.h"
#include "support/outputs.h"
#include "support/page.h"
#include "support/utf8.h"

extern char **environ;

static bool start(pid_t *process, int input, int output, char *const *arguments) {
    posix_spawn_file_actions_t actions;
    if (posix_spawn_file_actions_init(&actions) != 0) {
        return false;
    }
    (void)posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
    (void)posix_spawn_file_actions_adddup2(&actions, output, STDOUT_FILENO);
    const int error = posix_spawnp(process, arguments[0], &actions, NULL, arguments, environ);
    (void)posix_spawn_file_actions_destroy(&actions);
    if (error != 0) {
        rig_error("gnuplot: %s; expected it to be installed (Debian: gnuplot-nox) for the plot",
                  strerror(error));
    }
    return error == 0;
}

static bool wait_for(pid_t process) {
    int status = 0;
    while (waitpid(process, &status, 0) < 0) {
        if (errno != EINTR) {
            return false;
        }
    }
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

bool plot_available(void) {
    char name[] = "gnuplot";
    char version[] = "--version";
    char *const arguments[] = {name, version, NULL};
    const int nothing = open("/dev/null", O_RDWR | O_CLOEXEC);
    pid_t process = 0;
    bool good = nothing >= 0 && start(&process, nothing, nothing, arguments);
    if (nothing >= 0) {
        (void)close(nothing);
    }
    if (good && !wait_for(process)) {
        rig_error("gnuplot --version failed; expected a working gnuplot for the plot");
        good = false;
    }
    return good;
}

static bool format_of(const char *path, plot_format_t *format) {
    static const struct {
        const char *ending;
        plot_format_t format;
    } known[] = {{"", PLOT_SVG}, {".svg", PLOT_SVG}, {".png", PLOT_PNG}, {".html", PLOT_HTML}};
    const char *slash = strrchr(path, '/');
    const char *dot = strrchr(slash != NULL ? slash : path, '.');
    for (size_t k = 0; k < sizeof known / sizeof known[0]; ++k) {
        if (strcmp(dot != NULL ? dot : "", known[k].ending) == 0) {
            *format = known[k].format;
            return true;
        }
    }
    rig_error("%s: unknown picture format; expected a name ending in .svg, .png or "
              ".html",
              path);
    return false;
}

bool plot_open(plot_output_t *self, const char *path) {
    *self = (plot_output_t){.file = NULL};
    return path == NULL || (outputs_open(&self->file, path) && format_of(path, &self->format));
}

void plot_path_in(char *path, size_t size, const char *folder, const char *file,
                  const char *format) {
    const int stem = (int)(strrchr(file, '.') - file);
    (void)snprintf(path, size, "%s/%.*s.%s", folder, stem, file, format != NULL ? format : "svg");
}

static void set_terminal(FILE *script, plot_format_t format, int width, int height) {
    if (format == PLOT_PNG) { // drawn at twice the size, for high-resolution screens and print
        (void)fprintf(script,
                      "set terminal pngcairo size %d,%d enhanced background '#ffffff' "
                      "font 'DejaVu Sans,9.75' fontscale 2 pointscale 2 dashlength 2 lw 2\n",
                      2 * width, 2 * height);
    } else {
        (void)fprintf(script,
                      "set terminal svg size %d,%d dynamic enhanced background '#ffffff' "
                      "font 'DejaVu Sans,Helvetica,sans-serif,13' lw 1\n",
                      width, height);
    }
    (void)fputs("set encoding utf8\n", script);
}

bool plot_start(plot_t *self, const plot_output_t *output, const char *title, int width,
                int height) {
    char name[] = "gnuplot";
    char *const arguments[] = {name, NULL};
    int ends[2];
    *self = (plot_t){.output = output, .title = title};
    self->drawn = tmpfile();
    if (self->drawn == NULL || pipe(ends) != 0) {
        rig_error("plot: %s", strerror(errno));
        return false;
    }
    // The child shall see the end of its script when this process closes it.
    (void)fcntl(ends[1], F_SETFD, FD_CLOEXEC);
    (void)fcntl(ends[0], F_SETFD, FD_CLOEXEC);
    (void)signal(SIGPIPE, SIG_IGN);
    pid_t process = 0;
    const bool started = start(&process, ends[0], fileno(self->drawn), arguments);
    (void)close(ends[0]);
    self->script = started ? fdopen(ends[1], "w") : NULL;
    self->process = (long)process;
    if (self->script == NULL) {
        (void)close(ends[1]);
        (void)fclose(self->drawn);
        return false;
    }
    set_terminal(self->script, output->format, width, height);
    return true;
}

const char *plot_text(char string[PLOT_TEXT_LENGTH], const char *text) {
    enum { AT_MOST = 4 + 2 }; // a character, the last quote and the end
    static const char apostrophe[3] = {'\xe2', '\x80', '\x99'};
    const unsigned char *from = (const unsigned char *)text;
    size_t to = 0;
    string[to++] = '\'';
    while (*from != '\0' && to + AT_MOST <= PLOT_TEXT_LENGTH) {
        const int length = utf8_length(from);
        if (length > 1) {
            (void)memcpy(string + to, from, (size_t)length);
            to += (size_t)length;
        } else if (*from == '\'') {
            (void)memcpy(string + to, apostrophe, sizeof apostrophe);
            to += sizeof apostrophe;
        } else {
            string[to++] = (char)(length == 0 ? '?' : *from < ' ' || *from == 0x7f ? ' ' : *from);
        }
        from += length > 1 ? length : 1;
    }
    string[to++] = '\'';
    string[to] = '\0';
    return string;
}

void plot_style(FILE *script, const char *title, const plot_frame_t *frame) {
    const double left = 100.0 / frame->width; // margins in pixels
    const double to_legend = 12.0 / frame->width;
    const double below = 62.0 / frame->height;
    const double between = 26.0 / frame->height;
    const double title_height = 26.0 / frame->height;
    const double right = 1.0 - frame->legend / (double)frame->width;
    char string[PLOT_TEXT_LENGTH];
    (void)fprintf(script,
                  "set multiplot layout %d,1 margins screen %.4f, screen %.4f, screen %.4f, "
                  "screen %.4f spacing screen %.4f\n"
                  "set xrange [%.6g:%.6g]\n"
                  "set grid lc rgb '#e2e5e8' lw 0.6 dt 1\n"
                  "set border 3 lc rgb '#606060'\n"
                  "set tics nomirror out scale 0.6 textcolor rgb '#303030' font ',11'\n"
                  "set key at screen %.4f, graph 0.5 left center reverse Left samplen 1.6 "
                  "spacing 1.25 font ',11'\n"
                  "set format x ''\n",
                  frame->panels, left, right, below, 1.0 - frame->top / (double)frame->height,
                  between, frame->from_s, frame->to_s, right + to_legend);
    (void)fprintf(script,
                  "blue = '#1f5fa8'; red = '#c8372d'; green = '#2f8f4e'; grey = '#8a8f94'\n"
                  "set label 1000 at screen %.4f, screen %.4f left noenhanced font ',14' %s\n",
                  left, 1.0 - title_height, plot_text(string, title));
}

void plot_panel(FILE *script, const char *label) {
    char string[PLOT_TEXT_LENGTH];
    (void)fprintf(
        script,
        "set label 1001 %s at screen 0.015, graph 0.5 center rotate by 90 front noenhanced\n",
        plot_text(string, label));
}

/// Without disk space gnuplot draws only a part and still reports success.
static bool is_whole(FILE *drawn, plot_format_t format) {
    static const char png_end[] = {'I', 'E', 'N', 'D', '\xae', 'B', '`', '\x82'};
    char end[16 + 1] = "";
    const size_t size = sizeof end - 1u;
    if (fseek(drawn, -(long)size, SEEK_END) != 0 || fread(end, 1, size, drawn) != size) {
        return false;
    }
    return format == PLOT_PNG ? memcmp(end + size - sizeof png_end, png_end, sizeof png_end) == 0
                              : strstr(end, "</svg>") != NULL;
}

/// An error of writing `file` is reported when it is committed.
static void copy_picture(FILE *file, FILE *drawn) {
    char piece[4096];
    size_t length = 0;
    rewind(drawn);
    do {
        length = fread(piece, 1, sizeof piece, drawn);
        (void)fwrite(piece, 1, length, file);
    } while (length == sizeof piece);
}

bool plot_finish(plot_t *self) {
    const plot_output_t *output = self->output;
    const bool sent = fclose(self->script) == 0;
    self->script = NULL;
    const bool drawn = wait_for((pid_t)self->process);
    const bool whole = sent && drawn && is_whole(self->drawn, output->format);
    if (!sent || !drawn) {
        rig_error("gnuplot failed; expected it to draw the plot (its message is above)");
    } else if (!whole) {
        rig_error("gnuplot drew only a part of the plot; expected more space in the folder of "
                  "temporary files");
    } else if (output->format == PLOT_HTML) {
        page_write(output->file, self->title, self->drawn, output->text);
    } else {
        copy_picture(output->file, self->drawn);
    }
    (void)fclose(self->drawn);
    return whole;
}
