#!/usr/bin/env python3
"""Compares the best currents of golden/gen_references.py with the loci of motulator (PyPI, 0.5).

motulator finds MTPA, MTPV and the current limit from closed forms and by bisection, without resistance;
gen_references.py by trying every id. test_references.c holds the library to the latter.
"""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent / "golden"))
import gen_references as golden

try:
    import numpy as np
    from motulator.drive.control.sm import TorqueCharacteristics
    from motulator.drive.utils import SynchronousMachinePars
except ImportError as error:
    print(f"SKIP: motulator cannot be imported ({error})")
    sys.exit(77)

TOLERANCE = 2e-3  # of psi i_max: the loci are interpolated between 2000 points
OMEGA_rad_s = 100.0


def loci_of(motor):
    par = SynchronousMachinePars(n_p=1, R_s=0, L_d=motor[1], L_q=motor[2], psi_f=motor[3])
    return TorqueCharacteristics(par), 1.5


def best(motor, flux, tau):
    """Torque over its factor, and id, with the voltage that leaves `flux` and no resistance."""
    ideal = (0.0, *motor[1:5], flux * OMEGA_rad_s)
    found = golden.best(ideal, OMEGA_rad_s, tau, True)
    return golden.tau_of(ideal, found[1], found[2]), found[1]


def main():
    worst = {"MTPA": 0.0, "field weakening": 0.0, "MTPV": 0.0}
    for motor in golden.MOTORS:
        loci, factor = loci_of(motor)
        psi, i_max = motor[3], motor[4]
        mtpa = loci.mtpa_locus(i_max, N=2000)
        free = 2 * (psi + (motor[1] + motor[2]) * i_max)
        for share in (0.05, 0.2, 0.5, 0.8, 0.98):
            tau = share * mtpa.tau_M[-1] / factor
            _, i_d = best(motor, free, tau)
            wanted = mtpa.i_sd_vs_tau_M(tau * factor)
            worst["MTPA"] = max(worst["MTPA"], abs(i_d - wanted) / i_max)
        limits = loci.mtpv_and_current_limits(i_max, N=2000)
        flux = np.abs(mtpa.psi_s[-1])
        mtpv = loci.mtpv_locus(max_i_s=i_max, N=3).psi_s if psi < motor[1] * i_max else [0.0]
        least = max(psi - motor[1] * i_max, 0.05 * psi)
        for share in np.linspace(0.03, 0.97, 12):
            at = least + share * (flux - least)
            tau, _ = best(motor, at, 10 * psi * i_max)
            name = "MTPV" if at < np.abs(mtpv[-1]) else "field weakening"
            error = abs(tau - limits.tau_M_vs_abs_psi_s(at) / factor) / (psi * i_max)
            worst[name] = max(worst[name], float(error))
    failed = False
    for name, error in worst.items():
        good = 0 < error <= TOLERANCE
        failed = failed or not good
        print(f"{name:16s} largest difference {error:.1e} (limit {TOLERANCE:g}) {'ok' if good else 'FAIL'}")
    sys.exit(1 if failed else 0)


main()
