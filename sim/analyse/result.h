/// The results of the analysis: table values, frequency responses, poles and loops.
#ifndef RIG_ANALYSE_RESULT_H
#define RIG_ANALYSE_RESULT_H

#include <complex.h>

#include "analyse/joint.h"
#include "analyse/margins.h"

enum {
    ANALYSE_ROWS_MAX = 256,
    ANALYSE_CURVES_MAX = 80,
    ANALYSE_POINTS = 481,
    ANALYSE_POLES_MAX = 1024,
    ANALYSE_SPEEDS = 6,
    ANALYSE_LOOPS_MAX = 16,
    ANALYSE_TEXT = 48
};

/// One value: as printed in the paper, from its formula as printed, and correct. NaN: none.
typedef struct {
    const char *table;
    char setting[ANALYSE_TEXT];
    const char *quantity;
    const char *unit;
    double printed, as_printed, theory, sampled;
} analyse_row_t;

typedef enum { ANALYSE_THEORY, ANALYSE_SAMPLED, ANALYSE_AS_PRINTED } analyse_form_t;

/// A frequency response. Figures of paper 2 run over negative frequencies too.
typedef struct {
    const char *figure; ///< name of its plot
    char label[ANALYSE_TEXT];
    int family; ///< curves of one family share a colour
    analyse_form_t form;
    double omega_rad_s[ANALYSE_POINTS];
    double complex value[ANALYSE_POINTS];
} analyse_curve_t;

typedef struct {
    const char *figure;
    double sigma_rad_s;
    analyse_form_t form;
    double complex pole;
} analyse_pole_t;

/// The given drive at one speed.
typedef struct {
    double speed_rpm, omega_rad_s;
    double lag_deg;          ///< of the observer, from the recursion, in double
    double lag_firmware_deg; ///< the polynomial that the firmware evaluates
    double gain;             ///< estimated over true EMF
    margins_t margins;
    int poles;
    double complex pole[JOINT_STATES_MAX];
} analyse_speed_t;

/// A control loop of the given drive.
typedef struct {
    char name[ANALYSE_TEXT];
    double speed_rpm; ///< NaN: at any
    double crossover_rad_s, phase_deg;
    double gain_dB; ///< allowed increase of gain; NaN: no limit
} analyse_loop_t;

typedef struct {
    double ts_s;
    int rows, curves, poles, loops;
    analyse_row_t row[ANALYSE_ROWS_MAX];
    analyse_curve_t curve[ANALYSE_CURVES_MAX];
    analyse_pole_t pole[ANALYSE_POLES_MAX];
    analyse_speed_t at[ANALYSE_SPEEDS];
    analyse_loop_t loop[ANALYSE_LOOPS_MAX];
} analyse_t;

/// The next row; all values NaN.
analyse_row_t *analyse_row(analyse_t *self, const char *table, const char *setting,
                           const char *quantity, const char *unit);

/// The next curve, its frequencies evenly spaced in their logarithm (both > 0), or both halves of
/// +-`to` (`from` < 0: from -to to -from').
analyse_curve_t *analyse_curve(analyse_t *self, const char *figure, const char *label, int family,
                               analyse_form_t form);
void analyse_curve_log(analyse_curve_t *curve, double from_rad_s, double to_rad_s);
void analyse_curve_two_sided(analyse_curve_t *curve, double from_rad_s, double to_rad_s);

#endif
