"""The mechanism on a flexible base, with a flexible load, against a joint model integrated directly.

The joint model is Lagrange's: kinetic energy in the rates of rotor, load, load modes and base modes, a mass matrix,
and dry friction as a constraint while the rotor is stuck. It shares no line with the plant's blocks.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from layouts import changed, mechanism_of, paper_table
from mechid.command import Command, RateProfile
from mechid.kernel.equations import equations_of
from mechid.plant.flight import to_flight, with_base
from mechid.plant.layout import Base, Flying
from mechid.simulation.simulator import Simulator, TimeBase, simulate_run
from paper import ESTIMATED

BASE = [(0.0, 0.0, 0.8), (2.0 * np.pi * 31.0, 0.01, 3.0), (2.0 * np.pi * 90.0, 0.02, -2.0)]
"""Frequency rad/s, damping, shape; light enough that the mechanism moves its base."""
LOAD = [(2.0 * np.pi * 12.0, 0.01, 0.06)]
"""Frequency rad/s, damping, participation; its square is the effective inertia."""
RATE_HZ = 10_000.0


def flying(base, load, changes=None):
    """Return the paper's mechanism on these modes."""
    held = to_flight(mechanism_of(changed(paper_table(), changes or {})), None, [(w, z, p**2) for w, z, p in load])
    return with_base(held, Flying(base=Base.ON_MODES, modes=len(base)), base) if base else held


class JointModel:
    """Coordinates: rotor, load, load modes, base modes; then their rates; then both currents."""

    def __init__(self, values, base, load):
        self.v, self.base, self.load = values, np.array(base).reshape(-1, 3), np.array(load).reshape(-1, 3)
        n, m, k = 2 + len(load) + len(base), len(load), len(base)
        J, J_m = values["stepper.rotor_inertia"], values["load.inertia"]
        turn = np.zeros((2 + m, n))  # rates in inertial space of rotor and hub, and of the load's modes
        turn[:2, :2] = np.eye(2)
        turn[:2, 2 + m :] = self.base[:, 2]
        turn[2:, 2 : 2 + m] = np.eye(m)
        inertia = np.zeros((2 + m, 2 + m))
        inertia[0, 0], inertia[1, 1] = J, J_m
        inertia[1, 2:] = inertia[2:, 1] = self.load[:, 2]
        inertia[2:, 2:] = np.eye(m)
        self.M = turn.T @ inertia @ turn
        self.M[2 + m :, 2 + m :] += np.eye(k)
        self.momentum = (inertia @ turn)[:2].sum(axis=0)  # angular momentum of all that turns on the base
        springs = np.vstack([self.load, self.base])
        self.k, self.c = springs[:, 0] ** 2, 2.0 * springs[:, 1] * springs[:, 0]
        self.n = n

    def torques(self, x, u):
        """Return motor torque, gear torque and the currents' rates."""
        v, n = self.v, self.n
        a, w, i = x[0], x[n], x[2 * n :]
        shift = np.array([0.0, 0.5 * np.pi])
        sines = np.sin(50.0 * a + shift)
        k_m, R, L = v["stepper.torque_constant"], v["stepper.coil_resistance"], v["stepper.coil_inductance"]
        detents = sum(
            v[f"stepper.detent.{d}.amplitude"]
            * np.sin(2.0 * np.pi * np.degrees(a) / period + np.radians(v[f"stepper.detent.{d}.phase_deg"]))
            for d, period in ((0, 1.8), (1, 3.6))
        )
        G, K, D = v["gear.ratio"], v["gear.stiffness"], v["gear.damping"]
        T_rg = K / G**2 * (a - G * x[1]) + D / G**2 * (w - G * x[n + 1])
        return k_m * i @ sines - detents, T_rg, (u - R * i - k_m * w * sines) / L

    def accelerations(self, x, u, mode):
        """Return the accelerations and what friction does; in mode 0 the rotor is stuck."""
        T_mot, T_rg, _ = self.torques(x, u)
        T_fr = mode * self.v["friction.coulomb"] + self.v["friction.viscous"] * x[self.n]
        forces = np.concatenate(
            [[T_mot - T_rg - T_fr, 50.0 * T_rg], -self.k * x[2 : self.n] - self.c * x[self.n + 2 : 2 * self.n]]
        )
        if mode:
            return np.linalg.solve(self.M, forces), T_fr
        free = np.arange(1, self.n)
        acc = np.zeros(self.n)
        acc[free] = np.linalg.solve(self.M[np.ix_(free, free)], forces[free])
        return acc, T_mot - T_rg - self.M[0] @ acc

    def rates(self, x, u, mode):
        acc, _ = self.accelerations(x, u, mode)
        return np.concatenate([x[self.n : 2 * self.n], acc, self.torques(x, u)[2]])

    def run(self, excitation, times):
        """Return the torque on the base, (len(times),), from step to step and from switch to switch."""
        n, static = self.n, self.v["friction.static"]
        x, mode = np.zeros(2 * n + 2), 0
        x[2 * n :] = 5.7 * excitation.initial / self.v["stepper.coil_resistance"]
        out = np.zeros(times.size)
        edges = np.concatenate([[0.0], excitation.times, [times[-1] + 1e-9]])
        inputs = 5.7 * np.vstack([excitation.initial, excitation.values])
        for start, stop, u in zip(edges[:-1], edges[1:], inputs, strict=True):
            now = start
            while now < stop:
                mode = self._mode(x, u, mode, static)

                def ends(t, y, u=u, mode=mode):
                    return y[n] * mode if mode else static - abs(self.accelerations(y, u, 0)[1])

                ends.terminal, ends.direction = True, -1
                done = solve_ivp(
                    lambda t, y, u=u, mode=mode: self.rates(y, u, mode),
                    (now, stop),
                    x,
                    method="DOP853",
                    rtol=1e-10,
                    atol=1e-13,
                    events=ends,
                    dense_output=True,
                    max_step=5e-4,
                )
                inside = (times >= now) & (times < done.t[-1])
                for k in np.flatnonzero(inside):
                    out[k] = -self.momentum @ self.accelerations(done.sol(times[k]), u, mode)[0]
                x, now = done.y[:, -1].copy(), done.t[-1]
                if mode and done.status == 1:
                    x[n], mode = 0.0, 0
                elif done.status == 1:
                    mode = 2 * int(self.accelerations(x, u, 0)[1] > 0.0) - 1
        return out

    def _mode(self, x, u, mode, static):
        """Return the mode that holds at the beginning of a stretch."""
        if mode and x[self.n] * mode > 0.0:
            return mode
        holding = self.accelerations(x, u, 0)[1]
        if mode and x[self.n] == 0.0 and abs(holding) >= static * (1.0 - 1e-9):
            return mode
        return 0 if abs(holding) < static else (1 if holding > 0.0 else -1)


@pytest.mark.parametrize(
    ("base", "load", "stepping"),
    [
        pytest.param(BASE, LOAD, "full", id="base and load", marks=pytest.mark.slow),
        pytest.param(BASE, [], "full", id="base", marks=pytest.mark.slow),
        pytest.param([], LOAD, "full", id="load", marks=pytest.mark.slow),
        pytest.param(BASE, LOAD, "micro", id="microsteps", marks=pytest.mark.slow),
    ],
)
def test_the_coupled_mechanism_is_the_joint_model(base, load, stepping):
    """Truth: the joint model at 1e-10; the difference is the kernel's, relative to the RMS torque."""
    microsteps = 1 if stepping == "full" else 16
    command = Command(stepping=stepping, microsteps=microsteps, rate=RateProfile.constant(46.0))
    time_base = TimeBase(RATE_HZ, 1501)
    made = flying(base, load)
    got = simulate_run(Simulator(made.plant, command, time_base).run(made.kernel_values(), substeps=4, events=500))
    truth = JointModel(dict(ESTIMATED), base, load).run(command.excitation(0.151), time_base.times)
    smooth = np.ones(truth.size, dtype=bool)  # a sample that holds a jump is its mean, in the kernel
    for instant in got.switching.time:
        at = int(instant * RATE_HZ)
        smooth[max(at - 1, 0) : at + 3] = False
    assert smooth.mean() > 0.8
    error = np.sqrt(np.mean((got.torque - truth)[smooth] ** 2)) / np.sqrt(np.mean(truth**2))
    assert error < 2e-5


def test_a_heavy_base_is_a_bench():
    """Truth: with shapes going to zero the base does not move, and the torque is the blocked one."""
    command = Command(stepping="full", microsteps=1, rate=RateProfile.constant(46.0))
    heavy, held = flying([(200.0, 0.01, 1e-4)], []), flying([], [])
    runs = [
        simulate_run(Simulator(m.plant, command, TimeBase(RATE_HZ, 1001)).run(m.kernel_values(), substeps=2)).torque
        for m in (heavy, held)
    ]
    np.testing.assert_allclose(runs[0], runs[1], atol=1e-5 * np.abs(runs[1]).max())


def test_cables_pull_between_the_load_and_its_moving_base():
    """Truth: Newton in inertial space at random states: J_m (alpha_g'' + beta'') = T_applied - T_cable, typed by hand.

    The base's own equation has minus all momentum that changes on it: cables between it and the load push it back.
    """
    cable = {"law": "dahl", "stiffness": 0.4, "rest_angle": 0.1, "hysteresis": 0.03, "hysteresis_angle": 2e-3}
    mechanism = flying(BASE, [], {"load": {"cable": cable}})
    equations, p, r = equations_of(mechanism.plant), mechanism.kernel_values().tolist(), np.random.default_rng(5)
    names = list(map(str, mechanism.plant.states))
    for _ in range(5):
        x = dict(zip(names, r.normal(size=len(names)), strict=True)) | {"alpha": 0.4, "alpha_gear": 0.0081}
        modes = [
            list(s.modes).index("forward" if x[w] > 0 else "backward")
            for s, w in zip(mechanism.plant.switches, ("omega", "omega_gear"), strict=True)
        ]
        at = ([x[n] for n in names], [0.1, -0.2], equations.mode_symbols(modes), p)
        rate = dict(zip(names, equations.rates(*at), strict=True))
        eta = [(x[f"eta_{k}"], x[f"eta_dot_{k}"], rate[f"eta_dot_{k}"]) for k in range(len(BASE))]
        beta = sum(phi * a for (_, _, phi), (_, _, a) in zip(BASE, eta, strict=True))
        twist, twist_rate = x["alpha"] / 50 - x["alpha_gear"], x["omega"] / 50 - x["omega_gear"]
        applied = ESTIMATED["gear.stiffness"] * twist + ESTIMATED["gear.damping"] * twist_rate
        pull = 0.4 * (x["alpha_gear"] - 0.1) + 0.03 * x["h_cable"]
        load = ESTIMATED["load.inertia"] * (rate["omega_gear"] + beta)
        assert load == pytest.approx(applied - pull, rel=1e-9)
        with_base = -(ESTIMATED["stepper.rotor_inertia"] * (rate["omega"] + beta) + load)
        for (w, z, phi), (q, v, a) in zip(BASE, eta, strict=True):
            assert a + 2 * z * w * v + w**2 * q == pytest.approx(phi * with_base, rel=1e-6)
