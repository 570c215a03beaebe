#!/usr/bin/env python3
"""Compares the plant with motulator's on one live run: start to 1000 rpm, then a load ramp.

usage: plant_motulator.py PLANT_SHARED_LIBRARY [RECORDINGS_DIR]

motulator (PyPI, 0.5) simulates its own motor, shaft and zero-order-hold inverter under a small
current controller that lives here. The voltages it applied then drive the plant, whose shaft runs
freely against the same load: currents, speed and angle must come out the same. The recordings are
compared in test_plant.c; the second argument is accepted and not needed.
"""
import ctypes
import sys

try:
    import numpy as np
    from motulator.common.utils import abc2complex, complex2abc
    from motulator.drive import model
    from motulator.drive.utils import SynchronousMachinePars
except ImportError as error:
    print(f"SKIP: motulator cannot be imported ({error})")
    sys.exit(77)

# Jiang et al., Energies 2022, 15, 1943, Table 3.
POLE_PAIRS, RS_OHM, LD_H, LQ_H, PSI_WB = 3, 0.75, 3.5e-3, 9.8e-3, 0.142
J_KGM2, B_NMS = 0.0174, 7.5e-4
BUS_V, PERIOD_S, STOP_S, LOAD_AT_S = 200.0, 200e-6, 0.8, 0.5

# PLANT_REPLAY_COLUMNS of sim/plant/replay.h.
COLUMNS = 5


def load_torque(t):
    # A ramp: its mean over a period is its middle value. motulator also asks for whole arrays.
    return 5.0 * np.clip((t - LOAD_AT_S) / 0.05, 0.0, 1.0)


class Controller:
    """Speed P, current P with decoupling, on the true states. id* = -2 A exercises Ld too."""

    def __init__(self):
        self.rows = []

    def __call__(self, mdl):
        turn = mdl.machine.state.exp_j_theta_m
        speed = mdl.mechanics.state.w_M.real
        current = mdl.machine.i_s
        self.rows.append((current * turn, np.angle(turn), speed, mdl.machine.tau_M))
        w = POLE_PAIRS * speed
        iq_ref = np.clip(0.5 * (1000 * np.pi / 30 - speed), -10.0, 10.0)
        ref = complex(-2.0, iq_ref)
        u = complex(3.0 * (ref.real - current.real) - w * LQ_H * current.imag,
                    8.0 * (ref.imag - current.imag) + w * (PSI_WB + LD_H * current.real))
        u_abc = complex2abc((u + RS_OHM * ref) * turn * np.exp(1.5j * w * PERIOD_S))
        duty = 0.5 + (u_abc - 0.5 * (max(u_abc) + min(u_abc))) / BUS_V
        return PERIOD_S, np.clip(duty, 0.0, 1.0)

    def post_process(self):
        pass


class Recorder:
    """Zero-order hold that remembers the voltage of each period."""

    def __init__(self):
        self.voltages = []

    def __call__(self, period_s, duty):
        q = abc2complex(duty)
        self.voltages.append(q * BUS_V)
        return np.array([period_s]), np.array([q])


def run_motulator():
    par = SynchronousMachinePars(n_p=POLE_PAIRS, R_s=RS_OHM, L_d=LD_H, L_q=LQ_H, psi_f=PSI_WB)
    mdl = model.Drive(model.VoltageSourceConverter(u_dc=BUS_V), model.SynchronousMachine(par),
                      model.StiffMechanicalSystem(J=J_KGM2, B_L=B_NMS, tau_L=load_torque))
    mdl.pwm = Recorder()
    ctrl = Controller()
    # Steps this short leave the solver's own error far below the tolerances.
    model.Simulation(mdl, ctrl).simulate(t_stop=STOP_S, max_step=PERIOD_S / 4)
    return ctrl.rows, mdl.pwm.voltages


def run_plant(library, voltages):
    rows = len(voltages)
    pointer = ctypes.POINTER(ctypes.c_double)
    replay = ctypes.CDLL(library).plant_replay
    replay.restype = ctypes.c_int
    replay.argtypes = [pointer, ctypes.c_int, pointer, pointer, pointer, pointer, pointer]

    def array(values):
        return np.ascontiguousarray(values, dtype=np.float64)

    def address(values):
        return values.ctypes.data_as(pointer)

    parameters = array([POLE_PAIRS, RS_OHM, LD_H, LQ_H, PSI_WB, J_KGM2, B_NMS, BUS_V, PERIOD_S,
                        0.0, 0.0])
    u = np.array(voltages)
    alpha, beta = array(u.real), array(u.imag)
    load = array([load_torque((k + 0.5) * PERIOD_S) for k in range(rows)])
    out = np.zeros((rows, COLUMNS))
    if replay(address(parameters), rows, address(alpha), address(beta), None, address(load),
              address(out)) != 0:
        sys.exit("FAIL: the plant refused the parameters")
    return out


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    rows, voltages = run_motulator()
    out = run_plant(sys.argv[1], voltages)
    i, theta, speed, torque = (np.array(column) for column in zip(*rows))
    angle_error = np.angle(np.exp(1j * (out[:, 2] - theta)))
    # Both integrate the same equations: what is left is rounding and step errors. A wrong sign,
    # factor or period shows as 1e-2 or more.
    checks = [
        ("current", np.abs(out[:, 0] + 1j * out[:, 1] - i), 1e-3, "A"),
        ("speed", np.abs(out[:, 3] - speed), 5e-4, "rad/s"),
        ("angle", np.abs(angle_error), 1e-4, "rad"),
        ("torque", np.abs(out[:, 4] - torque), 5e-4, "Nm"),
    ]
    print(f"{len(rows)} periods, final speed {speed[-1]:.3f} rad/s, "
          f"peak current {np.abs(i).max():.2f} A, peak torque {np.abs(torque).max():.2f} Nm")
    failed = speed.max() < 80.0 or np.abs(i).max() < 8.0
    if failed:
        print("FAIL: the scenario did not run as meant")
    for name, error, limit, unit in checks:
        verdict = "ok" if error.max() <= limit else "FAIL"
        failed = failed or verdict == "FAIL"
        print(f"{name:8s} largest difference {error.max():.2e} {unit} (limit {limit:g}) {verdict}")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
