/// The motors, drives, plants and scenarios that come with the tool.
#ifndef RIG_DATA_FILES_H
#define RIG_DATA_FILES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "config/rig_config.h"

/// Path of the file for `name`. A bare name, without / and .ini, is the shipped `kind`/`name`.ini if there is
/// one, else the file `name`. Any other name is first the file `name`, then the shipped file of that name or of
/// that path before sim/data/ existed. Only regular files count. Without such a file the path is `name` itself,
/// so that the error of opening it shows that name. False if the path is too long.
bool data_files_find(const char *kind, const char *name, char *path, size_t size);

/// Loads a file, or a shipped one by its name, into `config`; nothing for NULL. False after a
/// message.
bool data_files_load_part(rig_config_t *config, const char *kind, const char *name);

/// Loads a name of --motors: a shipped motor with the drive and, if there is one, the plant of the same name;
/// or one file with [motor], [drive] and anything but a scenario. False after a message.
bool data_files_load_pair(rig_config_t *config, const char *name);

/// Prints the files of one kind with their titles. False after a message.
bool data_files_list(FILE *file, const char *kind);

/// Calls `take` with the name of each motor that has a drive of the same name. False after a message, or if
/// `take` returns false.
bool data_files_pairs(bool (*take)(void *user, const char *name), void *user);

#endif
