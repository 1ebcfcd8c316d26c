"""Loops closed sample by sample. Truth: the linear loop at small currents; the kernel under loops typed out."""

import math
from dataclasses import replace

import numpy as np
import pytest

from layouts import changed, mechanism_of, paper_table
from mechid.command import Command, Excitation, RateProfile
from mechid.exports.linear.linearisation import HeldMechanism
from mechid.exports.linear.loops.closing import (
    QUADRATURE,
    DrivenPlant,
    close_current_loops,
    close_position_loop,
    position_plant,
)
from mechid.exports.linear.loops.loop_file import CurrentLoop, LoopDesign, Notch, PositionLoop, SampledTiming
from mechid.exports.linear.loops.margins import loop_frequencies, margins_of, margins_on_grid
from mechid.exports.linear.loops.sample_by_sample import NonlinearPlant, measure_loop
from mechid.exports.linear.state_space import Uncertain
from mechid.plant.flight import to_flight
from mechid.plant.small_signal import small_signal
from mechid.simulation.simulator import Simulator, TimeBase

RESTS = Command(stepping="full", microsteps=1, rate=RateProfile.constant(0.0), start_angle_deg=20.0)
NOTHING = Uncertain((), (), np.zeros(0), np.zeros((0, 0)))
FAST, SLOW = 1e-4, 1e-3
KP, KI, CURRENT_KP, CURRENT_KI = 600.0, 1.2e5, 100.0, 20000.0


def held_of(changes=None):
    """Return the paper's mechanism in flight, holding 20 electrical degrees."""
    mechanism = to_flight(mechanism_of(changed(paper_table(), {"housing": None, **(changes or {})})))
    return HeldMechanism(small_signal(mechanism), RESTS, NOTHING)


def design_of(current_delay=1.0, position_delay=1.0, **changes):
    """Return loops with delays in samples."""
    position = PositionLoop(
        sensor="output_angle",
        kp=KP,
        ki=KI,
        kd=2.0,
        derivative_hz=200.0,
        timing=SampledTiming(period_s=SLOW, delay_s=position_delay * SLOW),
        notch=Notch(frequency_hz=46.0, damping=0.5, depth=0.2),
    )
    timing = SampledTiming(period_s=FAST, delay_s=current_delay * FAST)
    current = CurrentLoop(kp=CURRENT_KP, ki=CURRENT_KI, timing=timing)
    return replace(LoopDesign(current=current, position=position), **changes)


def loops_around(model, design):
    """Return the current loops around a model, by the phase, and under "position" the position loop."""
    plant = DrivenPlant(model.matrices, model.inputs.names, model.outputs.names, RESTS.start_angle_rad)
    loops = close_current_loops(plant, design.current) if design.current else {}
    driven = position_plant(plant, design, loops.get("phase_a"))
    return {**loops, "position": close_position_loop(driven, design, design.position.notch, 1.0)}


@pytest.fixture(scope="module")
def held():
    return held_of()


@pytest.fixture(scope="module")
def models(held):
    return held.models(0, 0)


@pytest.mark.parametrize("delays", [(1.0, 1.0), (0.4, 0.0), (1.6, 1.3), (0.0, 0.35)])
def test_small_sines_find_the_linear_loop(held, models, delays):
    """Truth: the linear loop at its crossovers: 0.02 dB, 0.1 deg with currents of 0.3 % of the held one."""
    design = design_of(*delays)
    for name, driven, which, run in (
        ("stuck", "added_voltage_phase_a", "phase_a", (1, 6)),
        ("free", "added_voltage_phase_b", "phase_b", (1, 28)),
        ("free", QUADRATURE, "position", (1, 70)),
        ("free", QUADRATURE, "position", (1, 11)),
        ("free", QUADRATURE, "position", (3, 10)),
    ):
        loop = loops_around(models[name], design)[which]
        found = measure_loop(NonlinearPlant(held, models[name]), design, loop, driven, *run, 3e-3)
        linear = loop.open.response([run[0] / run[1] / loop.open.period_s])[0, 0, 0]
        assert abs(20.0 * math.log10(abs(found / linear))) < 0.02
        assert abs(np.degrees(np.angle(found / linear))) < 0.1


def test_a_position_loop_without_a_current_loop(held, models):
    """Truth: the linear loop; the quadrature command is then a voltage."""
    design = design_of(current=None)
    loop = loops_around(models["free"], design)["position"]
    found = measure_loop(NonlinearPlant(held, models["free"]), design, loop, QUADRATURE, 1, 40, 1e-3)
    assert found == pytest.approx(loop.open.response([25.0])[0, 0, 0], rel=3e-3)


def test_a_wrong_loop_is_seen(held, models):
    """Truth: the measurement is for this: a gain that is off by 5 %."""
    design = design_of()
    loop = loops_around(models["stuck"], design)["phase_a"]
    wrong = design_of(current=replace(design.current, kp=1.05 * CURRENT_KP))
    found = measure_loop(NonlinearPlant(held, models["stuck"]), wrong, loop, "added_voltage_phase_a", 1, 28, 1e-2)
    assert abs(20.0 * math.log10(abs(found / loop.open.response([1.0 / 28 / FAST])[0, 0, 0]))) > 0.3


class HandClosedKernel:
    """The compiled kernel, a sample at a time, under PI, PID and notch as difference equations typed here."""

    def __init__(self, held, seconds):
        self.plant, count = held.plant, round(seconds / FAST)
        self.names = [s.name for s in self.plant.inputs]
        times = (np.arange(count) + 0.6) * FAST
        driven = Excitation(held.inputs, times, np.tile(held.inputs, (count, 1)), tuple(self.names))
        base = TimeBase(1.0 / FAST, count)
        self.made = Simulator(self.plant, replace(RESTS, start="equilibrium"), base, known_edges=driven)
        self.edges = self.made._edge_values.reshape(count, -1)
        self.run = self.made.run(held.opened.mechanism.kernel_values(), block=1, substeps=2)
        self.columns = [self.names.index(f"added_voltage_phase_{x}") for x in "ab"]
        self.outputs = list(self.plant.outputs)

    def close(self, sine, position):
        """Return sine and controller output of the measured loop: quadrature, or the voltage of phase A."""
        theta, given = RESTS.start_angle_rad, []
        rows = [self.outputs.index(f"current_phase_{x}") for x in "ab"]
        sums, still, pid, commands = np.zeros(2), None, HandPid(), [0.0]
        for k, block in enumerate(self.run.blocks()):
            y = block.y[0].copy()
            still = y if still is None else still
            if position and k % 10 == 0:
                out = pid.step(-(y - still)[self.outputs.index("output_angle")])
                given.append(out)
                commands.append(out + sine[k // 10])
            # The position controller acts a whole sample of its own late.
            q = commands[-2] if position and len(commands) > 1 else 0.0
            error = q * np.array([math.sin(theta), math.cos(theta)]) - (y - still)[rows]
            sums = sums + CURRENT_KI * FAST * error
            u = CURRENT_KP * error + sums
            if not position:
                given.append(u[0])
                u = u + np.array([sine[k], 0.0])
            self.edges[k, self.columns] = u
        return np.array(given)


class HandPid:
    """Notch and PID of `design_of`, by the formulas of the documentation."""

    def __init__(self):
        w = 2.0 * math.pi * 46.0
        c = w / math.tan(w * SLOW / 2.0)
        self.above, self.below = (
            [c * c + 2.0 * d * 0.5 * w * c + w * w, 2.0 * (w * w - c * c), c * c - 2.0 * d * 0.5 * w * c + w * w]
            for d in (0.2, 1.0)
        )
        self.e, self.n, self.sum, self.d, self.a = [0.0, 0.0], [0.0, 0.0], 0.0, 0.0, math.exp(-2e2 * 2 * math.pi * SLOW)

    def step(self, error):
        b, a = self.above, self.below
        n = (b[0] * error + b[1] * self.e[0] + b[2] * self.e[1] - a[1] * self.n[0] - a[2] * self.n[1]) / a[0]
        self.sum += KI * SLOW * n
        self.d = self.a * self.d + (1.0 - self.a) * 2.0 * (n - self.n[0]) / SLOW
        self.e, self.n = [error, self.e[0]], [n, self.n[0]]
        return KP * n + self.sum + self.d


@pytest.mark.slow
@pytest.mark.parametrize("position", [False, True])
def test_margins_are_those_of_a_swept_sine_through_the_compiled_kernel(position):
    """Truth: the kernel with its switches, sticking under the current loop, dry friction taken away under position.

    Margins of the swept sine: 0.3 dB, 1 deg.
    """
    held = held_of({"friction": {"static": 0.0, "coulomb": 0.0}} if position else None)
    name = "free" if position else "stuck"
    loop = loops_around(held.models(0, 0)[name], design_of(current_delay=0.6))["position" if position else "phase_a"]
    own, period_s = margins_of(loop.open), loop.open.period_s
    size, seconds = (2e-2, 1.6) if position else (0.1, 0.2)
    hertz, ratio = [], []
    for crossover in (own.phase_frequency_hz, own.gain_frequency_hz):
        for share in (0.6, 0.85, 1.0, 1.15, 1.4):
            count = round(seconds / period_s)
            f = round(crossover * share * seconds / 2.0) / (seconds / 2.0)
            sine = size * np.cos(2.0 * np.pi * f * period_s * np.arange(count))
            given = HandClosedKernel(held, seconds).close(sine, position)
            turning = np.exp(-2j * np.pi * f * period_s * np.arange(count))[count // 2 :]
            found = -(given[count // 2 :] @ turning) / ((given + sine)[count // 2 :] @ turning)
            hertz.append(f)
            ratio.append(found / loop.open.response([f])[0, 0, 0])
    order = np.argsort(hertz)
    hertz, ratio = np.array(hertz)[order], np.array(ratio)[order]

    def factor(f):
        return np.interp(f, hertz, np.abs(ratio)) * np.exp(1j * np.interp(f, hertz, np.angle(ratio)))

    grid = loop_frequencies(loop.open)
    swept = margins_on_grid(
        grid,
        loop.open.response(grid)[:, 0, 0] * factor(grid),
        lambda f: complex(loop.open.response([f])[0, 0, 0] * factor(f)),
    )
    print(position, own, swept)  # noqa: T201
    assert swept.gain_dB == pytest.approx(own.gain_dB, abs=0.3)
    assert swept.phase_deg == pytest.approx(own.phase_deg, abs=1.0)
