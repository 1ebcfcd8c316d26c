"""A value and the interval beside it are of the same thing, in every table of a budget."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

from mechid.analysis.residual_emission import CENTRES_HZ, TRACKED, residual_emission
from mechid.analysis.residual_file import ResidualRecord
from mechid.budgets import budget as budget_module
from mechid.budgets.budget import make_budget
from mechid.budgets.budget_file import read_budget_file
from mechid.budgets.carried import Carried
from mechid.budgets.discrepancy import Discrepancy
from mechid.budgets.files import write_budget
from mechid.budgets.flight_entry import Flight
from mechid.budgets.flying_mechanism import read_flying
from mechid.budgets.indices import Index
from mechid.budgets.line_of_sight import respond
from mechid.budgets.numbers import budget_data
from mechid.budgets.other_errors import OtherError
from mechid.budgets.over_rate import level_curve, rms_bands, torque_bands, total_bands
from mechid.budgets.requirement import Requirement
from mechid.budgets.residual_source import ResidualHere, ResidualSource
from mechid.structure import Modes, Structure
from paper_estimate import write_estimate_of_paper
from states_by_hand import state_by_hand

RATE = 20.0
STRUCTURE = Structure(
    name="s",
    line_of_sight=("x",),
    model=Modes(np.array([300.0]), np.array([0.01]), np.array([1.0]), np.array([[1.0]])),
)
"""Stiff: below its mode all frequencies reach the line of sight alike."""
MOVED = 0.05
"""Of each line by the parameter's sigma."""
LINES = {0.5: 0.3, 1.0: 1.0, 2.0: 0.4}
"""Of the model's torque by order, N m."""


@pytest.fixture(scope="module")
def estimate(tmp_path_factory):
    """Return an estimate of one parameter that moves each line by 5 %."""
    flying = read_flying(write_estimate_of_paper(tmp_path_factory.mktemp("estimate")), Flight())
    return replace(
        flying, names=("gear.damping",), covariance=np.eye(1), discrepancy=Discrepancy(of_profiles_alone=True)
    )


def lacking(lines, *, hidden=0.0, density=0.0, rates=4):
    """Return what a model lacks: lines by their order, N m, and a density up to 100 Hz."""
    orders = np.array(TRACKED)
    amplitude = np.array([lines.get(q, 0.0) for q in TRACKED])
    flat = np.where(CENTRES_HZ < 100.0, density, 0.0)
    return ResidualHere(
        rate=RATE,
        orders=orders,
        amplitude=amplitude,
        limit=np.where(amplitude > 0.0, amplitude, hidden),
        density=flat,
        rates=rates,
        known=np.ones(orders.size, dtype=bool),
        outside=False,
    )


def response_with(here):
    values = np.array(list(LINES.values()))
    orders = [round(2 * order) for order in LINES]
    state = state_by_hand(RATE, orders, values, gradient=MOVED * values[:, None].astype(complex))
    return respond(state, STRUCTURE, here, 200.0)


LACKING = {
    "nothing": None,
    "little at its lines": lacking({1.0: 0.1}),
    "as much at its lines": lacking({1.0: 1.0, 2.0: 1.0}),
    "four times as much": lacking({0.5: 2.0, 1.0: 4.0, 2.0: 2.0}),
    "at another order": lacking({0.75: 3.0}),
    "a density": lacking({}, density=0.05),
    "all of these, and hidden lines": lacking({1.0: 1.0, 0.75: 2.0}, density=0.02, hidden=0.5),
    "known from one rate": lacking({1.0: 1.0, 0.75: 1.0}, rates=1),
}


def requirement():
    return Requirement(
        name="r",
        index=Index("RPE", 0.1),
        axis="x",
        limit_rad=1.0,
        interpretation="temporal",
        confidence=0.95,
        evaluation_period_s=60.0,
    )


@pytest.mark.parametrize("here", LACKING.values(), ids=LACKING)
def test_the_value_lies_within_its_interval(estimate, here):
    """Truth: of what is believed, which no error moves to one side."""
    response = response_with(here)
    (lines,), ((low, high),) = response.rms(), rms_bands([response], estimate, 0)[0]
    assert low < lines < high
    (total,), ((low, high),) = response.total_rms(), total_bands([response], estimate, 0)[0]
    assert low < total < high
    for errors in ((), (OtherError(name="n", kind="random", axes=np.array([True]), size_rad=1e-6, bandwidth_hz=50.0),)):
        curve = level_curve(requirement(), [[response]], estimate, errors, 0)
        assert curve.band[0, 0] < curve.level[0] < curve.band[0, 1]
    (band,) = torque_bands([response], estimate, 0)
    assert np.all((band[:, 0] < np.abs(response.state.lines)) & (np.abs(response.state.lines) < band[:, 1]))


def test_the_interval_of_the_lines_is_that_of_the_lines(estimate):
    """Truth: a parameter that moves all lines alike by 5 %; what the model lacks has no part in it."""
    response = response_with(LACKING["four times as much"])
    expected = response.rms()[0] * (1.0 + MOVED * np.array([-1.96, 1.96]))
    np.testing.assert_allclose(rms_bands([response], estimate, 0)[0, 0], expected, rtol=0.03)


def test_the_total_against_the_closed_form(estimate):
    """Truth: mean squares add up; a stiff structure turns each N m into 1/w0^2 rad (w below its mode)."""
    response = response_with(lacking({1.0: 0.6, 0.75: 0.8}))
    gain = {q: abs(STRUCTURE.to_line_of_sight(np.array([q * RATE]))[0, 0]) for q in (*LINES, 0.75)}
    lines = sum(0.5 * (gain[q] * size) ** 2 for q, size in LINES.items())
    beside = 0.5 * (gain[1.0] * 0.6) ** 2 + 0.5 * (gain[0.75] * 0.8) ** 2
    assert response.total_rms()[0] == pytest.approx(np.sqrt(lines + beside), rel=1e-9)


def test_the_interval_of_the_total_is_that_of_what_may_be(estimate):
    """Truth: 20 000 draws of lines 5 % off and of what is lacking, whose power is F(2, 2 n) distributed."""
    rng, n, count = np.random.default_rng(7), 4, 20_000
    response = response_with(lacking({1.0: 1.0}, rates=n))
    at = np.array([q * RATE for q in LINES])
    gain = np.abs(STRUCTURE.to_line_of_sight(at)[:, 0])
    lines = np.array(list(LINES.values())) * (1.0 + MOVED * rng.normal(size=(count, 1)))
    power = rng.f(2, 2 * n, size=count)
    lines = lines.astype(complex)
    lines[:, 1] += np.sqrt(power) * np.exp(2j * np.pi * rng.random(count))
    true = np.sqrt(0.5 * np.sum(np.abs(gain * lines) ** 2, axis=1))
    ends = np.array([total_bands([response], estimate, seed)[0, 0] for seed in range(20)])
    assert np.mean(true < ends[:, :1]) == pytest.approx(0.025, abs=0.01)  # each by the quantiles of 200 draws
    assert np.mean(true > ends[:, 1:]) == pytest.approx(0.025, abs=0.01)


BUDGET = """\
estimate = "estimate.json"
axis = "rz"
[structure]
file = "structure.toml"
[[mode]]
name = "slew"
command = { stepping = "micro", microsteps = 16 }
rates = [19.0, 21.0]
duty = 0.5
[[mode]]
name = "run up"
command = { stepping = "micro", microsteps = 16, rate_profile = [[0.0, 0.0], [1.0, 20.0]] }
duration_s = 2.0
rms_window_s = 0.5
duty = 0.1
[[error]]
name = "sensor"
kind = "random"
size_rad = 1e-7
bandwidth_hz = 20.0
[[requirement]]
name = "stability"
index = "RPE"
window_s = 0.1
axis = "x"
limit_rad = 1e-4
interpretation = "temporal"
confidence = 0.95
evaluation_period_s = 60.0
"""
MODES = """\
line_of_sight = ["x", "y"]
[[mode]]
frequency_hz = 21.0
damping = 0.005
interface = 0.15
line_of_sight = [-0.04, 0.02]
"""


def of_bench(rng, rate):
    """Return what noise and two lines, at an order of the model and at another, leave of a record."""
    time = np.arange(10_000) / 5000.0
    left = 2e-3 * rng.normal(size=time.size)
    for order, size in ((1.0, 0.02), (0.75, 0.01)):
        left += size * np.cos(2.0 * np.pi * order * rate * time)
    found = residual_emission(left, rate * time, 5000.0)
    return ResidualRecord(
        name=f"r{rate}", stepping="micro", microsteps=16, noise_sigma=2e-3, sample_rate_hz=5000.0, rates=found
    )


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Return a budget of an estimate that left something of its records, and the folder of its files."""
    folder = tmp_path_factory.mktemp("budget")
    write_estimate_of_paper(folder, fit_percent=99.0)
    (folder / "budget.toml").write_text(BUDGET, encoding="utf-8")
    (folder / "structure.toml").write_text(MODES, encoding="utf-8")
    rng = np.random.default_rng(3)
    source = ResidualSource(tuple(of_bench(rng, rate) for rate in (18.0, 19.5, 20.5, 22.0)), Carried(None))

    def with_residual(path, flight):
        read = read_flying(path, flight)
        return replace(read, residual=source, discrepancy=replace(read.discrepancy, of_profiles_alone=True))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(budget_module, "read_flying", with_residual)
        budget = make_budget(read_budget_file(folder / "budget.toml"))
    write_budget(budget, folder / "out")
    return budget, folder / "out"


def rows_of(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


PAIRS = {
    "line_of_sight.csv": [
        (f"{kind}_{axis}_rad", f"{low}_{axis}_rad", f"{high}_{axis}_rad")
        for kind, low, high in (("rms", "low95", "high95"), ("total", "total_low95", "total_high95"))
        for axis in ("x", "y")
    ],
    "harmonics.csv": [("torque_amplitude_Nm", None, "bound_Nm"), ("residual_Nm", None, "bound_Nm")],
    "emission.csv": [("modelled_rms_Nm", None, "bound_rms_Nm"), ("residual_rms_Nm", None, "bound_rms_Nm")],
}
"""Values with the ends of their intervals; a bound has an upper one alone."""


@pytest.mark.parametrize(("file", "pairs"), PAIRS.items(), ids=PAIRS)
def test_in_every_row_of_a_table_the_value_lies_within_its_interval(made, file, pairs):
    rows = rows_of(made[1] / file)
    assert len(rows) >= 2
    for row in rows:
        for value, low, high in pairs:
            assert float(row[value]) <= float(row[high]) * (1.0 + 1e-6), (file, row)
            assert low is None or float(row[low]) <= float(row[value]), (file, row)


def test_every_interval_of_the_json_file_holds_its_value(made):
    """Truth: whatever has a key with ci95 in it stands beside a key of the same name without."""
    data = json.loads(json.dumps(budget_data(made[0])))
    found = list(intervals_of(data))
    assert {name for name, *_ in found} >= {
        "rms_ci95_rad",
        "total_rms_ci95_rad",
        "levels_ci95_rad",
        "ci95_Nm",
        "ci95_rad",
        "margin95",
    }
    for name, value, interval in found:
        low, high = np.moveaxis(np.asarray(interval, dtype=float), -1, 0)
        inside = (low <= np.asarray(value) * (1.0 + 1e-9)) & (np.asarray(value) <= high * (1.0 + 1e-9))
        assert inside.all(), (name, value, interval)


VALUES = {"ci95_Nm": "torque_amplitude_Nm", "ci95_rad": "level_rad", "margin95": "margin"}


def intervals_of(entry):
    """Yield the name, the value and the ends of every interval in nested dicts and lists."""
    if isinstance(entry, list):
        for each in entry:
            yield from intervals_of(each)
    if not isinstance(entry, dict):
        return
    for key, interval in entry.items():
        if "95" not in key:
            yield from intervals_of(interval)
            continue
        value = entry[VALUES.get(key, key.replace("_ci95", ""))]
        if isinstance(interval, dict):
            yield from ((key, value[name], ends) for name, ends in interval.items())
        else:
            yield key, value, interval
