#include "report/report_motor.h"

#include <math.h>

#include "config/config_json.h"
#include "support/units.h"

typedef struct {
    const char *key; ///< key of the INI file, if there is one
    const char *unit;
    const char *words;
    double value;
} line_t;

enum { LINES = 10 };

static void lines_of(line_t lines[LINES], const lode_drive_config_t *drive,
                     const design_t *design) {
    const lode_motor_t *motor = &drive->motor;
    const double np = (double)motor->pole_pairs;
    const double psi = (double)motor->psi_Wb;
    const double kt = (double)lode_motor_kt_Nm_A(motor);
    const double ke = sqrt(3.0) * psi * np * rig_rad_s_from_rpm(1000.0);
    const line_t all[LINES] = {
        {"poles", "", "magnet poles, twice the pole pairs", 2.0 * np},
        {"R_line_line_Ohm", "Ohm", "between two terminals", 2.0 * (double)motor->Rs_Ohm},
        {"Ld_line_line_mH", "mH", "between two terminals, d axis", 2.0e3 * (double)motor->Ld_H},
        {"Lq_line_line_mH", "mH", "the same, q axis", 2.0e3 * (double)motor->Lq_H},
        {"KV_rpm_V", "rpm/V", "peak EMF between two terminals", 1000.0 / ke},
        {"ke_Vpk_krpm", "V/krpm", "the same", ke},
        {"ke_Vrms_krpm", "Vrms/krpm", "RMS EMF between two terminals", ke / sqrt(2.0)},
        {"kt_Nm_A", "Nm/A", "by the amplitude of the phase current", kt},
        {"kt_Nm_Arms", "Nm/Arms", "by its RMS value", kt * sqrt(2.0)},
        {"no_load_rpm", "rpm", "by the EMF alone, with the voltage that control may use",
         rig_rpm_from_rad_s(design->speeds.no_load_rad_s) / np},
    };
    for (int k = 0; k < LINES; ++k) {
        lines[k] = all[k];
    }
}

void report_motor_text(FILE *file, const lode_drive_config_t *drive, const design_t *design) {
    line_t lines[LINES];
    lines_of(lines, drive, design);
    (void)fputs("\nthe motor in data-sheet quantities: compare with yours\n", file);
    for (int k = 0; k < LINES; ++k) {
        (void)fprintf(file, "%-16s %10.4g %-9s  %s\n", lines[k].key, lines[k].value, lines[k].unit,
                      lines[k].words);
    }
    for (int k = 0; k < PLAUSIBLE_RATIOS; ++k) {
        const plausible_ratio_t *ratio = &design->plausible.ratio[k];
        if (!isnan(ratio->value)) {
            (void)fprintf(file, "%-31s %8.4g %-18s  catalogue: %g .. %g\n", ratio->name,
                          ratio->value, ratio->unit, ratio->usual_low, ratio->usual_high);
        }
    }
}

void report_motor_json(cJSON *root, const lode_drive_config_t *drive, const design_t *design) {
    line_t lines[LINES];
    lines_of(lines, drive, design);
    cJSON *sheet = cJSON_AddObjectToObject(root, "data_sheet");
    for (int k = 0; k < LINES; ++k) {
        config_json_number(sheet, lines[k].key, lines[k].value);
    }
    cJSON *checks = cJSON_AddArrayToObject(root, "plausible");
    for (int k = 0; k < PLAUSIBLE_RATIOS; ++k) {
        const plausible_ratio_t *ratio = &design->plausible.ratio[k];
        cJSON *item = config_json_item(checks);
        (void)cJSON_AddStringToObject(item, "key", ratio->key);
        config_json_number(item, "value", ratio->value);
        (void)cJSON_AddStringToObject(item, "unit", ratio->unit);
        config_json_number(item, "least", ratio->least);
        config_json_number(item, "most", ratio->most);
        (void)cJSON_AddBoolToObject(item, "doubtful", plausible_is_doubtful(ratio));
    }
}
