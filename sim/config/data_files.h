/// The motors, drives, plants and scenarios that come with the tool.
#ifndef RIG_DATA_FILES_H
#define RIG_DATA_FILES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "config/rig_config.h"

/// Path of what `name` stands for. A bare name, without / and .ini, is the shipped `kind`/`name`.ini if there is
/// one, else the file `name`. Any other is first the file `name`, then the shipped one of that name, or the one
/// whose path before sim/data/ it is. Only regular files count. Where there is none `name` again, so that opening
/// it fails with its own name. False if the path is too long.
bool data_files_find(const char *kind, const char *name, char *path, size_t size);

/// Loads a file, or a shipped one by its name, into `config`; nothing for NULL. False after a
/// message.
bool data_files_load_part(rig_config_t *config, const char *kind, const char *name);

/// Loads what a name of --motors stands for: a shipped motor, the drive of its name, and the plant of its name
/// where there is one; or one file with [motor], [drive] and anything but a scenario. False after a message.
bool data_files_load_pair(rig_config_t *config, const char *name);

/// Prints the files of one kind with their titles. False after a message.
bool data_files_list(FILE *file, const char *kind);

/// Calls `take` with the name of each motor that has a drive of the same name. False after a message, or
/// where `take` says so.
bool data_files_pairs(bool (*take)(void *user, const char *name), void *user);

#endif
