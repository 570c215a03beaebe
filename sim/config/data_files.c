#include "config/data_files.h"

#include <dirent.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "config/ini_config.h"
#include "support/diag.h"

#ifndef RIG_DATA_DIR
#define RIG_DATA_DIR "sim/data"
#endif

/// Data of an installed tool: <prefix>/bin/lodestar has <prefix>/share/lodestar. NULL if there is none.
static const char *installed_folder(void) {
    static const char share[] = "/../share/lodestar";
    static char path[RIG_PATH_LENGTH];
    const ssize_t length = readlink("/proc/self/exe", path, sizeof path - 1u);
    if (length <= 0) {
        return NULL;
    }
    path[length] = '\0';
    char *slash = strrchr(path, '/');
    if (slash == NULL || (size_t)(slash - path) + sizeof share > sizeof path) {
        return NULL;
    }
    (void)memcpy(slash, share, sizeof share);
    return access(path, R_OK) == 0 ? path : NULL;
}

static const char *data_folder(void) {
    const char *folder = getenv("LODESTAR_DATA");
    if (folder == NULL) {
        folder = installed_folder();
    }
    return folder != NULL ? folder : RIG_DATA_DIR;
}

static bool ends_in_ini(const char *name) {
    const size_t length = strlen(name);
    return length > 4 && strcmp(name + length - 4, ".ini") == 0;
}

/// A folder or a device is not a regular file.
static bool is_file(const char *path) {
    struct stat about;
    return stat(path, &about) == 0 && S_ISREG(about.st_mode) && access(path, R_OK) == 0;
}

/// The shipped file of that kind, also by its path before sim/data/ existed (sim/motors/jiang2022.ini).
static int shipped(const char *kind, const char *name, char *path, size_t size) {
    if (strchr(name, '/') == NULL) {
        return snprintf(path, size, "%s/%s/%s%s", data_folder(), kind, name,
                        ends_in_ini(name) ? "" : ".ini");
    }
    char folder[32];
    (void)snprintf(folder, sizeof folder, "sim/%s/", kind);
    const char *found = strstr(name, folder);
    if (found == NULL) {
        return snprintf(path, size, "%s", name);
    }
    const char *rest = found + strlen("sim/");
    return snprintf(path, size, "%.*sdata/%s", (int)(rest - name), name, rest);
}

/// Resolves a name: a bare name is first a shipped file, then a file in the current folder; any other name is
/// the reverse.
static int candidate(int number, const char *kind, const char *name, char *path, size_t size) {
    const bool bare = strchr(name, '/') == NULL && !ends_in_ini(name);
    return (number == 0) == bare ? shipped(kind, name, path, size)
                                 : snprintf(path, size, "%s", name);
}

bool data_files_find(const char *kind, const char *name, char *path, size_t size) {
    for (int number = 0; number < 2; ++number) {
        const int length = candidate(number, kind, name, path, size);
        if (length < 0 || (size_t)length >= size) {
            rig_error("%s: expected a path of at most %zu characters", name, size - 1);
            return false;
        }
        if (is_file(path)) {
            return true;
        }
    }
    (void)snprintf(path, size, "%s", name); // opening the file reports the error
    return true;
}

bool data_files_load_part(rig_config_t *config, const char *kind, const char *name) {
    char path[RIG_PATH_LENGTH];
    return name == NULL ||
           (data_files_find(kind, name, path, sizeof path) && ini_config_load_part(config, path));
}

bool data_files_load_pair(rig_config_t *config, const char *name) {
    char motor[RIG_PATH_LENGTH];
    char drive[RIG_PATH_LENGTH];
    char plant[RIG_PATH_LENGTH];
    if (!data_files_find("motors", name, motor, sizeof motor) ||
        !data_files_find("drives", name, drive, sizeof drive) ||
        !data_files_find("plants", name, plant, sizeof plant)) {
        return false;
    }
    if (!is_file(motor) || !is_file(drive)) {
        rig_error("--motors %s: not found; expected the name of a motor that has a drive of the "
                  "same name "
                  "(see `lodestar list`), or an INI file with [motor] and [drive]",
                  name);
        return false;
    }
    return ini_config_load_part(config, motor) && ini_config_load_part(config, drive) &&
           (!is_file(plant) || ini_config_load_part(config, plant));
}

static int is_ini(const struct dirent *entry) {
    return ends_in_ini(entry->d_name) ? 1 : 0;
}

/// The files of one kind, sorted by name; -1 after a message.
static int scan(const char *kind, char folder[1024], struct dirent ***entry) {
    (void)snprintf(folder, 1024, "%s/%s", data_folder(), kind);
    const int count = scandir(folder, entry, is_ini, alphasort);
    if (count < 0) {
        rig_error("%s: %s; expected the tool's data there, or in the folder LODESTAR_DATA", folder,
                  strerror(errno));
    }
    return count;
}

bool data_files_pairs(bool (*take)(void *user, const char *name), void *user) {
    char folder[1024];
    struct dirent **entry = NULL;
    const int count = scan("motors", folder, &entry);
    bool good = count >= 0;
    for (int k = 0; k < count; ++k) {
        char path[1536];
        char *name = entry[k]->d_name;
        (void)snprintf(path, sizeof path, "%s/drives/%s", data_folder(), name);
        name[strlen(name) - strlen(".ini")] = '\0';
        good = good && (access(path, R_OK) != 0 || take(user, name));
        free(entry[k]);
    }
    free(entry);
    return good;
}

bool data_files_list(FILE *file, const char *kind) {
    char folder[1024];
    struct dirent **entry = NULL;
    const int count = scan(kind, folder, &entry);
    if (count < 0) {
        return false;
    }
    (void)fprintf(file, "%s (%s)\n", kind, folder);
    for (int k = 0; k < count; ++k) {
        char path[1536];
        char title[200];
        (void)snprintf(path, sizeof path, "%s/%s", folder, entry[k]->d_name);
        ini_config_title(path, title, sizeof title);
        (void)fprintf(file, "  %-25.*s %s\n", (int)strlen(entry[k]->d_name) - 4, entry[k]->d_name,
                      title);
        free(entry[k]);
    }
    free(entry);
    return true;
}
