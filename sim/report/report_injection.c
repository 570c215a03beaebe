#include "report/report_injection.h"

#include "config/config_json.h"
#include "support/units.h"

/// Why injection is not possible, in words.
static const char *reason_of(lode_status_t status) {
    static const struct {
        lode_status_t status;
        const char *words;
    } reasons[] = {
        {LODE_ERROR_HFI_SALIENCY,
         "the rotor is not salient enough at i_max: Lq'/Ld must be at least 1.15"},
        {LODE_ERROR_HFI_VOLTAGE, "the injection voltage would exceed half of the voltage circle"},
        {LODE_ERROR_HFI_DEAD_TIME,
         "the dead time would hide the response: raise hfi.V_h_V, or shorten the dead time"},
        {LODE_ERROR_HFI_SPEEDS, "w1 and w2 do not lie between 0 and the estimator's limit"},
        {LODE_ERROR_ID_BIAS, "hfi.id_A is more than i_max"},
    };
    for (size_t k = 0; k < sizeof reasons / sizeof reasons[0]; ++k) {
        if (reasons[k].status == status) {
            return reasons[k].words;
        }
    }
    return "the library refuses the configuration with it";
}

static double rpm_of(const lode_drive_config_t *config, double omega_rad_s) {
    return rig_rpm_from_rad_s(omega_rad_s) / (double)config->motor.pole_pairs;
}

static const char *use_of(const injection_t *i) {
    if (i->on) {
        return "in use";
    }
    return i->recommended ? "recommended, and the default: the current vector of a start has too "
                            "little torque "
                            "for a load of 0.8 of the rated one"
                          : "possible: hfi.mode = on";
}

void report_injection_text(FILE *file, const lode_drive_config_t *config, const injection_t *i) {
    (void)fprintf(file, "\nsignal injection, for zero and low speed: %s\n",
                  i->on ? "on" : "off (hfi.mode)");
    if (i->status != LODE_OK) {
        (void)fprintf(file, "not possible: %s (%s)\n", reason_of(i->status),
                      lode_status_name(i->status));
        (void)fprintf(file, "saliency at i_max: Lq'/Ld = %.2f\n", i->saliency);
        return;
    }
    (void)fprintf(
        file,
        "%s\n"
        "saliency at i_max: Lq'/Ld = %.2f, from Lq_H, Lq_fall or hfi.Lq_i_max_H\n"
        "amplitude: %.1f V, %.0f %% of the voltage circle; id %.3g A\n"
        "ripple, peak to peak: %.3g A; at i_max %.3g Nm\n"
        "tone: %.0f Hz\n"
        "angle error: %.2f degrees rms from the noise of the currents, %.1f where a current passes "
        "through zero\n"
        "position by injection up to %.1f rpm, by the EMF from %.1f rpm; sigma %.0f rad/s\n",
        use_of(i), i->saliency, i->V_h_V, 100.0 * i->circle_share, i->id_A, i->ripple_A,
        i->ripple_Nm, i->tone_Hz, i->noise_deg, rig_deg_from_rad(i->dead_time_rad),
        rpm_of(config, i->w1_rad_s), rpm_of(config, i->w2_rad_s), i->sigma_rad_s);
    (void)fprintf(file,
                  "reversal of a load of the largest torque, %.3g Nm: angle error %.1f degrees "
                  "with injection, %.1f with the EMF\n",
                  i->torque_Nm, i->step_deg, i->step_emf_deg);
    if (i->loses_steps) {
        (void)fprintf(file, "warning: a QPLL has no disturbance state and does not follow so light "
                            "a rotor; expected estimator.pll = leso-qpll\n");
    }
}

void report_injection_json(cJSON *root, const injection_t *i) {
    cJSON *out = cJSON_AddObjectToObject(root, "injection");
    (void)cJSON_AddBoolToObject(out, "on", i->on);
    (void)cJSON_AddStringToObject(out, "status", lode_status_name(i->status));
    (void)cJSON_AddBoolToObject(out, "recommended", i->recommended);
    config_json_number(out, "saliency", i->saliency);
    config_json_number(out, "V_h_V", i->V_h_V);
    config_json_number(out, "circle_share", i->circle_share);
    config_json_number(out, "ripple_A", i->ripple_A);
    config_json_number(out, "ripple_Nm", i->ripple_Nm);
    config_json_number(out, "tone_Hz", i->tone_Hz);
    config_json_number(out, "noise_deg", i->noise_deg);
    config_json_number(out, "dead_time_rad", i->dead_time_rad);
    config_json_number(out, "id_A", i->id_A);
    config_json_number(out, "w1_rad_s", i->w1_rad_s);
    config_json_number(out, "w2_rad_s", i->w2_rad_s);
    config_json_number(out, "sigma_rad_s", i->sigma_rad_s);
    config_json_number(out, "torque_Nm", i->torque_Nm);
    config_json_number(out, "step_deg", i->step_deg);
    config_json_number(out, "step_emf_deg", i->step_emf_deg);
    (void)cJSON_AddBoolToObject(out, "loses_steps", i->loses_steps);
}
