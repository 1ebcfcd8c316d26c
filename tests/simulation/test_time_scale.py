"""A driver's clock that is off, the mechanism in true time. Truth: the command as it really came, without any clock."""

from dataclasses import replace

import numpy as np
import pytest

from golden_variants import VARIANTS
from layouts import mechanism_of
from mechid.command import Command, RateProfile, Timing
from mechid.plant.time_powers import COMMON, time_powers, unit_time_power
from mechid.simulation.batch import Batch
from mechid.simulation.simulator import Simulator, TimeBase
from mechid.simulation.start import Start
from mechid.units import time_power
from runs import rms

POINTS = [(0.0, 10.0), (0.1, 80.0), (0.2, 80.0), (0.2, -40.0), (0.3, 0.0)]
BASE = TimeBase(1e4, 2501, 0.004)
OFFSET_S = 0.01


def commanded(speed, **also):
    """Return the command as a clock faster by a factor brings it."""
    rate = RateProfile.through([(t / speed, rate * speed) for t, rate in POINTS])
    return Command(stepping="micro", microsteps=8, rate=rate, start_angle_deg=17.0, **also)


def outputs(simulator, p, timing, directions=None):
    """Return the outputs of a run, (n, n_y), and with directions its derivatives and rates."""
    wanted = np.zeros((p.size, 0)) if directions is None else directions
    blocks = list(map(_copied, simulator.run(p, timing=timing, directions=wanted).blocks()))
    return [np.concatenate(each) for each in zip(*blocks, strict=True)]


def _copied(block):
    return block.y.copy(), block.jacobian.copy(), block.rate.copy()


STEPPED = [
    name
    for name, table in VARIANTS.items()
    if "drive" not in table and not table["stepper"].get("drive", "").startswith("measured")
]
"""Variants that steps drive: what measured channels drive has no clock beside its own."""


@pytest.mark.parametrize("ppm", [-3000.0, 1e4])
@pytest.mark.parametrize("name", [n if n == "paper" else pytest.param(n, marks=pytest.mark.slow) for n in STEPPED])
def test_the_mechanism_moves_in_the_recorders_time(name, ppm):
    """Truth: steps at the instants at which the driver's clock makes them, all else as it is; every quantity."""
    mechanism = mechanism_of(VARIANTS[name])
    plant = mechanism.plant.with_outputs(tuple(mechanism.plant.offered))
    speed, p = 1.0 + 1e-6 * ppm, _values(mechanism, plant)
    (found, *_) = outputs(Simulator(plant, commanded(1.0), BASE, latest_s=0.1), p, Timing(OFFSET_S, ppm))
    true = Simulator(plant, commanded(speed), BASE, latest_s=0.1)
    (expected, *_) = outputs(true, p, Timing(OFFSET_S / speed))
    for j, quantity in enumerate(plant.outputs):
        assert rms(found[:, j] - expected[:, j]) <= 1e-6 * rms(expected[:, j]), quantity
    by_driver, *_ = outputs(Simulator(plant, commanded(1.0), BASE, latest_s=0.1), p, Timing(OFFSET_S, ppm, "driver"))
    assert rms(by_driver[:, 0] - expected[:, 0]) > 1e-6 * rms(expected[:, 0])


def _values(mechanism, plant):
    """Return the values of the kernel's parameters of a plant that measures more."""
    own = dict(zip(mechanism.plant.parameters, mechanism.kernel_values().tolist(), strict=True))
    symbols, expressions = plant.file_map
    values = dict(zip(symbols, [mechanism.value(name) for name in plant.declarations], strict=True))
    return np.array(
        [own[s] if s in own else float(e.subs(values)) for s, e in zip(plant.parameters, expressions, strict=True)]
    )


@pytest.mark.slow
def test_runs_side_by_side_have_clocks_of_their_own():
    """Truth: each alone."""
    mechanism = mechanism_of(VARIANTS["paper"])
    plant = mechanism.plant.with_outputs(("torque", "rotor_rate"))
    simulator, p = Simulator(plant, commanded(1.0), BASE, latest_s=0.1), _values(mechanism, plant)
    timings = [Timing(0.01 + 1e-4 * k, 5e3 * k) for k in range(4)]
    begun = [simulator.run(p, timing=timing, directions=np.zeros((p.size, 0))) for timing in timings]
    together = np.concatenate([y.copy() for _, _, y in Batch(begun).blocks()], axis=1)
    for y, timing in zip(together, timings, strict=True):
        alone, *_ = outputs(simulator, p, timing)
        np.testing.assert_allclose(y, alone, rtol=0, atol=1e-9 * rms(alone))


@pytest.mark.slow
def test_derivatives_are_per_value_in_true_time():
    """Truth: central differences; parameters with and without a unit of time, and a state of the start."""
    mechanism = mechanism_of(VARIANTS["paper"])
    plant = mechanism.plant.with_outputs(("torque", "rotor_rate"))
    p, timing = _values(mechanism, plant), Timing(-0.002, 1e4)
    begun = Start({"start.rate": 0.4}, {3: {"start.rate": 1.0}})
    simulator = Simulator(plant, commanded(1.0).begin_at(0.001), BASE, latest_s=0.1, capacity=4, start=begun)
    names = ("J_m", "K_s", "R")
    directions = np.zeros((p.size, 4))
    for lane, name in enumerate(names):
        directions[list(map(str, plant.parameters)).index(name), lane] = 1.0
    _, jacobian, _ = outputs(simulator, p, timing, directions)
    for lane, step in enumerate([1e-6 * directions[:, k] @ p for k in range(3)]):
        high, low = (outputs(simulator, p + s * step * directions[:, lane], timing)[0] for s in (1.0, -1.0))
        expected = (high - low) / (2.0 * step)
        for j in range(2):
            assert rms(jacobian[:, j, lane] - expected[:, j]) <= 2e-4 * rms(expected[:, j]), (names[lane], j)
    high, low = (
        outputs(replace(simulator, start=Start({"start.rate": 0.4 + step})), p, timing) for step in (1e-5, -1e-5)
    )
    expected = (high[0] - low[0]) / 2e-5
    for j in range(2):
        assert rms(jacobian[:, j, 3] - expected[:, j]) <= 2e-4 * rms(expected[:, j])


@pytest.mark.parametrize(
    ("unit", "power"),
    [
        *(("kg*m^2", 2.0), ("g cm2", 2.0), ("N m s/rad", 1.0), ("mN m/(rad/s)", 1.0), ("ms", 1.0), ("N m", 0.0)),
        *(("N/m", 0.0), ("V s/rad", 0.0), ("mH", 0.0), ("Hz", -1.0), ("rpm", -1.0), ("mohm", -1.0), ("rad/s^2", -2.0)),
        *(("N*m*s^2/rad^2", 2.0), ("1", 0.0), ("%", 0.0), ("widgets", 0.0), ("", 0.0)),
    ],
)
def test_units_have_their_power_of_time(unit, power):
    """Truth: by hand, from newton, metre, ampere and second."""
    assert unit_time_power(unit) == power


def test_common_units_are_as_pint_has_them():
    for unit, power in COMMON.items():
        assert unit == "1" or time_power(unit) == power, unit


def test_a_kernels_own_parameters_have_the_power_of_what_they_are_made_of():
    """Truth: by hand: the cosine part of a detent is a torque, sqrt(K_t/J_a) a rate."""
    for table in VARIANTS.values():
        plant = mechanism_of(table).plant
        powers = dict(zip(map(str, plant.parameters), time_powers(plant), strict=True))
        assert powers.get("a_1", 0.0) == pytest.approx(0.0, abs=1e-12)
        assert powers.get("omega_t", -1.0) == pytest.approx(-1.0)
