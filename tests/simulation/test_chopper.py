"""A chopped current drive. Truth: exponentials of a coil, the slow twin, the balance of energy, its own average."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from layouts import LAYOUTS, changed, paper_with
from mechid.analysis.look import Drive, look_at
from mechid.checks.run import check
from mechid.designs.run import design
from mechid.errors import InputFileError
from mechid.identification.identify import make_problem
from paper import constant
from runs import base, rms, run_kernel, run_twin
from synthetic import campaign, record

CURRENTS = ("current_phase_a", "current_phase_b")
OUTPUTS = ("torque", *CURRENTS, "voltage_phase_a", "voltage_phase_b", "rotor_angle", "rotor_rate")
HELD = {"friction": {"static": 50.0, "coulomb": 50.0}}
"""Friction that nothing moves."""
R, L, U, I = 9.9, 0.045, 12.0, 0.5 * np.sqrt(0.5)
"""Of the coil and its supply; I is the commanded current of each phase in a full step."""
CHOPPERS = {
    "clock, slow": {"frequency_hz": 8e3},
    "clock, fast": {"frequency_hz": 8e3, "decay": "fast"},
    "clock, mixed": {"frequency_hz": 8e3, "decay": "mixed", "fast_s": 2e-5},
    "band, slow": {"hysteresis_A": 0.02},
    "band, fast": {"hysteresis_A": 0.02, "decay": "fast"},
}


QUICK = ("clock, mixed",)
CHAOTIC = "clock, fast"
"""Its current falls faster than it rises: from tick to tick any difference grows 1.8 times, rounding too."""
NAMES = [pytest.param(n, marks=() if n in QUICK else pytest.mark.slow) for n in CHOPPERS if n != CHAOTIC]


def chopped(name, changes=None, outputs=OUTPUTS):
    """Return the paper's mechanism without housing on a chopped drive."""
    table = changed({"housing": None, **LAYOUTS["current limit"]}, {"stepper": {"chop": CHOPPERS[name]}})
    m = paper_with(changed(table, changes or {}))
    return replace(m, plant=m.plant.with_outputs(outputs))


def after(seconds, i, u):
    """Return the current of a coil at rest some time after it had i, under a voltage."""
    return u / R + (i - u / R) * np.exp(-seconds * R / L)


def until(i, end, u):
    """Return how long a coil at rest takes from one current to another under a voltage."""
    return L / R * np.log((u / R - i) / (u / R - end))


def finely_sampled(m, seconds):
    """Return a run in full steps, sampled every microsecond, and the current of phase A."""
    run = run_kernel(m, constant(50.0), base(seconds, rate_hz=1e6), substeps=1)
    return run, np.asarray(run.values["current_phase_a"])


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_a_coil_at_rest_goes_through_its_exponentials(name):
    """Truth: the exponentials from peak to valley and back, whose times are known where a band or a clock ends them."""
    own = CHOPPERS[name]
    u_off = {"slow": 0.0, "fast": -U, "mixed": 0.0}[own.get("decay", "slow")]
    if band := own.get("hysteresis_A"):
        peak, valley = I + band / 2, I - band / 2
        period = until(valley, peak, U) + until(peak, valley, u_off)
    else:
        peak, period, valley = I, 1.0 / own["frequency_hz"], I
        for _ in range(200):  # from tick to tick: up to the peak, then down for the rest of the period
            off = period - until(valley, peak, U)
            fast = min(own.get("fast_s", 0.0), off)
            valley = after(off - fast, after(fast, peak, -U), u_off)
    run, i = finely_sampled(chopped(name, HELD), 0.06)
    settled = i[-5000:]
    assert settled.max() == pytest.approx(peak, abs=U / L * 1e-6)
    assert settled.min() == pytest.approx(valley, abs=2 * U / L * 1e-6)
    crossings = np.flatnonzero(np.diff(np.sign(settled - 0.5 * (peak + valley))) > 0)
    assert np.diff(crossings).mean() * 1e-6 == pytest.approx(period, rel=1e-3)
    on = np.asarray(run.values["voltage_phase_a"])[-5000:] > 0.0
    assert on.mean() * period == pytest.approx(until(valley, peak, U), abs=2e-6)  # two samples


@pytest.mark.parametrize("name", NAMES)
def test_kernel_and_derivatives_are_those_of_the_twin(name):
    """Truth: the slow twin and its variational equations, over a step in which coils fill."""
    m, time_base = chopped(name), base(0.03)
    chosen = [list(map(str, m.plant.parameters)).index(q) for q in ("R_loop", "U_loop", "k_m")]
    command = constant(46.0, microsteps=4)
    kernel = run_kernel(m, command, time_base, sensitive=chosen, substeps=16)
    twin = run_twin(m, command, time_base, sensitive=chosen)
    assert len(kernel.switching.time) == len(twin.switching)
    for j, quantity in enumerate(OUTPUTS):
        y = np.asarray(kernel.values[quantity])
        apart = np.abs(y - twin.y[:, j]) > 1e-6 * rms(twin.y[:, j])
        assert apart.sum() <= (2 if "voltage" in quantity else 0), quantity  # a sample may fall on a switch
    found, slopes = kernel.jacobian["rotor_angle"], twin.jacobian[:, OUTPUTS.index("rotor_angle")]
    assert np.all(np.linalg.norm(found - slopes, axis=0) <= 1e-4 * np.linalg.norm(slopes, axis=0))


@pytest.mark.slow
def test_peaks_of_a_current_that_falls_faster_than_it_rises_skip_ticks():
    """Truth: the commanded current, which no peak exceeds; 16 ms have 128 ticks of the clock."""
    run, i = finely_sampled(chopped(CHAOTIC, HELD), 0.06)
    voltage = np.asarray(run.values["voltage_phase_a"])[-16_000:]
    trips = np.sum((voltage[:-1] > 0.0) & (voltage[1:] < 0.0))
    assert i[-16_000:].max() == pytest.approx(I, abs=U / L * 1e-6)
    assert 64 < trips < 120


def test_its_energy_balances():
    """Truth: what the terminals take is heat, energy stored and work between any two switches, to 1e-9."""
    m = chopped("clock, mixed", {"stepper": {"chop": {"frequency_hz": 2e3, "fast_s": 1e-4}}})
    time_base = base(0.05, rate_hz=1e6)
    run = run_kernel(m, constant(46.0), time_base, substeps=1)
    got = {q: np.asarray(v) for q, v in run.values.items()}
    i, u = (np.stack([got[f"{q}_phase_{x}"] for x in "ab"]) for q in ("current", "voltage"))
    shape = np.sin(50.0 * got["rotor_angle"] + 0.5 * np.pi * np.arange(2)[:, None])
    emf, t = m.value("stepper.current_limit.back_emf_constant") * got["rotor_rate"] * shape, time_base.times
    taken = 0.0
    for begin, end in pairwise(np.unique([0.0, 1.0 / 46.0, *run.switching.time, 0.05])):
        inside = np.flatnonzero((t > begin + 1.5e-6) & (t < end - 1.5e-6))
        if inside.size < 16:
            continue
        part = slice(inside[0], inside[-1] + 1)
        stored = 0.5 * L * np.sum(i[:, [inside[0], inside[-1]]] ** 2, axis=0)
        in_, out = (integral(t[part], np.sum(x[:, part], axis=0)) for x in (u * i, R * i**2 + emf * i))
        assert abs(in_ - out - (stored[1] - stored[0])) <= 1e-9 * max(abs(in_), 1e-3), (begin, end)
        taken += abs(in_)
    assert taken > 1e-2


def integral(t, y):
    """Return the integral of smooth samples, by a spline of the seventh degree."""
    return float(make_interp_spline(t, y, k=7).integrate(t[0], t[-1]))


@pytest.mark.slow
def test_a_narrow_band_of_fast_decay_comes_to_the_average():
    """Truth: the drive limited by its supply alone; slow decay does not follow a falling command as this does."""
    command, time_base = constant(46.0, microsteps=4), base(0.1)
    narrow = chopped("band, fast", {"stepper": {"chop": {"hysteresis_A": 0.005}}}, ("rotor_angle", *CURRENTS))
    average = paper_with({"housing": None, **LAYOUTS["current limit"]})
    average = replace(average, plant=average.plant.with_outputs(("rotor_angle", *CURRENTS)))
    found, expected = (run_kernel(m, command, time_base, substeps=8).values for m in (narrow, average))
    for quantity in CURRENTS:
        assert np.abs(np.asarray(found[quantity]) - np.asarray(expected[quantity])).max() < 0.01
    angle = np.asarray(expected["rotor_angle"])
    assert rms(np.asarray(found["rotor_angle"]) - angle) < 1e-3 * rms(angle)


@pytest.mark.parametrize(
    ("chop", "words"),
    [
        ({}, "stepper.chop: nothing switches a phase on again; give frequency_hz or hysteresis_A"),
        ({"frequency_hz": 2e4, "decay": "mixed"}, "stepper.chop.fast_s"),
        ({"frequency_hz": 2e4, "fast_s": 1e-5}, "stepper.chop.fast_s"),
        ({"frequency_hz": -2e4}, "stepper.chop.frequency_hz: found -20000"),
        ({"hysteresis_A": {"value": 0.1}}, "stepper.chop.hysteresis_A: found a table"),
        ({"hysteresis_A": 0.1, "supply_V": 24.0}, "unknown key; the keys here are frequency_hz, hysteresis_A"),
        ({"hysteresis_B": 0.1}, 'unknown key; did you mean "hysteresis_A"?'),
        ({"hysteresis_A": 0.1, "decay": "quick"}, 'stepper.chop.decay: unknown decay "quick"'),
    ],
)
def test_a_chopper_that_cannot_be_is_refused(chop, words):
    table = changed(LAYOUTS["current limit"], {"stepper": {"chop": chop}})
    with pytest.raises(InputFileError) as raised:
        paper_with(table)
    assert words in str(raised.value)


def test_a_chopper_needs_supply_and_coil():
    table = changed(LAYOUTS["current drive"], {"stepper": {"chop": {"hysteresis_A": 0.1}}})
    with pytest.raises(InputFileError, match=r"stepper.chop: needs \[stepper.current_limit\]"):
        paper_with(table)


@pytest.mark.parametrize(
    ("clock", "seen"), [(2.3e3, (2300.0, 4600.0, 3100.0)), (21e3, (1000.0, 2000.0, 3000.0)), (0.0, ())]
)
def test_its_clock_is_named_where_a_record_shows_it(clock, seen):
    """Truth: what sampling at 10 kHz makes of the multiples of the clock; without a clock nothing is named."""
    chop = {"hysteresis_A": 0.02, "frequency_hz": clock}
    named = paper_with(changed(LAYOUTS["current limit"], {"stepper": {"chop": chop}})).named_lines
    assert [f for one in named for f in one.lines_hz(40.0, 1e4)] == pytest.approx(list(seen))
    t = np.arange(20_000) / 1e4
    y = sum(np.sin(2.0 * np.pi * f * t) for f in seen) + 1e-3 * np.random.default_rng(1).standard_normal(t.size)
    (channel,) = look_at(record("r", y, constant(40.0)).data, Drive(command=constant(40.0), named=named)).channels
    lines = {round(one.line.frequency_hz): [name.name for name in one.named] for one in channel.lines}
    assert all(lines[round(f)] == ["chopper"] for f in seen)
    assert sum(map(len, lines.values())) == len(seen)


UNKNOWN = {"value": 1000.0, "min": 500.0, "max": 2000.0}


def test_no_fit_is_tried_switch_by_switch():
    """Truth: the message; `check` says it in a warning, before records are simulated."""
    made = campaign(chopped("band, slow", {"gear": {"stiffness": UNKNOWN}}), record("r", np.zeros(100), constant(46.0)))
    with pytest.raises(InputFileError, match=r"stepper.chop: no fit follows .* its average, \[stepper.current_limit\]"):
        make_problem(made, 1)
    with pytest.raises(InputFileError, match=r"stepper.chop: no fit follows"):
        design(made)
    (line,) = check(made).warnings
    assert line.startswith("stepper.chop: no fit follows a chopper switch by switch")
