#include "reproduce/li_rows.h"

#include "reproduce/li_work.h"

// ---- The paper ----------------------------------------------------------------------------------

static const char introduction[] =
    "Li, Hu, Ma, Liu: FA-LESO for a dual three-phase IPMSM, Sections III and V.\n"
    "\n"
    "THE PAPER'S MOTOR TABLE IS NOT AVAILABLE: THE MACHINE IS A STAND-IN with the windings of "
    "Eldeeb et al., IEEE PEDS 2017 (R 0.8 Ohm,\n"
    "Ld 6.4 mH, Lq 17.4 mH, Lxy 0.9 mH, psi 0.1746 Vs, 5 pole pairs). Ours: J = 0.01 kgm2, 300 V, "
    "10 kHz, rated load 6.25 Nm (2.4 A),\n"
    "and sigma = 150 rad/s for the LESO-QPLL, which the paper does not give. Observers with the "
    "gains of Table II, as those of the\n"
    "experiments are not available either; id* = 0; current and speed control of the library, "
    "with the xy currents controlled to zero.\n"
    "In Figs. 13 to 15, xy and k2 the EMF of each set has 6 % of 5th and 7th harmonic.\n"
    "\n"
    "printed      the paper's equations in forward Euler, lag not compensated; ideal inverter\n"
    "dead time    the same with 2 us of dead time, not corrected\n"
    "exact raw    observer and PLL of the library, lag not compensated; ideal inverter\n"
    "exact        the same with the lag compensated\n"
    "corrected    the same with 2 us of dead time, corrected\n"
    "theory       closed form of what the paper prints\n"
    "\n"
    "The drive starts with an encoder; then the estimator takes over at the true angle and speed. "
    "Angles are electrical, estimate minus\n"
    "truth. Mean and pp (peak to peak): of the last second, 3 s or more after the last change. "
    "Deviation, and angle in load steps: the\n"
    "largest distance from the mean before. \"lost\": more than 90 deg off; \"stalls\": the speed "
    "is not held. An ideal inverter gives\n"
    "exactly the mean voltage asked for. A claim with ~ is met within 30 % or 1.5 units by the "
    "column printed; \"improved\": exact has\n"
    "at most 0.7 of printed.\n";

static const paper_t paper = {
    .name = LI_PAPER,
    .reference = "Li, Hu, Ma, Liu: Sensorless Control of Dual Three-Phase IPMSM Based on Frequency "
                 "Adaptive Linear Extended State Observer",
    .introduction = introduction,
    .columns = LI_COLUMNS,
    .shown = LI_COLUMNS,
    .heading = {"printed", "dead time", "exact raw", "exact", "corrected"},
    .key = {"as_printed", "as_printed_dead_time", "exact_uncompensated", "exact", "corrected"},
    .judged = LI_PRINTED,
    .best = LI_EXACT,
    .window_s = LI_WINDOW_s,
};

bool li_reproduction_run(table_t *table, const rig_config_t *base) {
    static li_work_t work;
    work = (li_work_t){.base = base, .table = table, .theory = li_theory_of(base)};
    *table = (table_t){.paper = &paper};
    progress_start(&work.progress);
    li_steady(&work);
    li_harmonics(&work);
    li_changes(&work);
    (void)progress_end(&work.progress);
    return !work.failed;
}
