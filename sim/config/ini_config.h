/// Reads INI files and --set into a configuration, through the schema.
#ifndef RIG_INI_CONFIG_H
#define RIG_INI_CONFIG_H

#include <stddef.h>

#include "config/rig_config.h"

/// Reads a scenario: first the files that its [scenario] section names (relative to its own folder), then the
/// scenario itself, which overrides them. False after a message "FILE:LINE: [section] key: ...".
bool ini_config_load_scenario(rig_config_t *config, const char *path);

/// Reads a file of a motor, a drive or a plant: anything but [scenario] and phases. A file that has been read
/// is not read again: motor and drive may be in one file.
bool ini_config_load_part(rig_config_t *config, const char *path);

/// "section.key=value", overrides the files. `option`: the name of the option on the command line.
bool ini_config_set(rig_config_t *config, const char *option, const char *assignment);

/// For a trial: this valid value in place of whatever files and --set give for the same quantity.
void ini_config_override(rig_config_t *config, const char *section, const char *key,
                         const char *value);

/// The value in use, as written in a file; a rated speed that was not given is that of the designed drive.
void ini_config_value(const rig_config_t *config, int row, char *text, size_t size);

/// The source of the value of a key: "FILE:LINE", "from FILE", "command line", "measured",
/// or "default or computed", with what a field that is still open stands for.
void ini_config_where(const rig_config_t *config, int row, char *text, size_t size);

/// First comment line of the file, without its mark: its title in a list.
void ini_config_title(const char *path, char *text, size_t size);

/// `name` as seen from the folder of the file `from`. False: longer than `size`.
bool ini_config_relative(const char *from, const char *name, char *path, size_t size);

#endif
