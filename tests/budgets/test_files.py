"""A value and the interval beside it are of the same thing, in every table of a budget."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

from mechid.analysis.residual_emission import residual_emission
from mechid.analysis.residual_file import ResidualRecord
from mechid.budgets import budget as budget_module
from mechid.budgets.bench_to_flight import BenchToFlight
from mechid.budgets.budget import make_budget
from mechid.budgets.budget_file import read_budget_file
from mechid.budgets.example import STRUCTURE
from mechid.budgets.files import budget_texts
from mechid.budgets.flying_mechanism import flying_estimate
from mechid.budgets.numbers import budget_numbers
from mechid.budgets.residual_source import ResidualSource
from mechid.identification.result.fit_file import read_fit
from mechid.writing import write_together
from paper_estimate import write_estimate_of_paper

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
    fit = read_fit(write_estimate_of_paper(folder, fit_percent=99.0))
    (folder / "budget.toml").write_text(BUDGET, encoding="utf-8")
    (folder / "structure.toml").write_text(STRUCTURE, encoding="utf-8")
    rng = np.random.default_rng(3)
    source = ResidualSource(tuple(of_bench(rng, rate) for rate in (18.0, 19.5, 20.5, 22.0)), BenchToFlight(None))

    def with_residual(fit, flight):
        read = flying_estimate(fit, flight)
        return replace(read, residual=source, discrepancy=replace(read.discrepancy, of_profiles_alone=True))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(budget_module, "flying_estimate", with_residual)
        budget = make_budget(read_budget_file(folder / "budget.toml"), fit)
    write_together(folder / "out", budget_texts(budget, budget_numbers(budget)))
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
    data = json.loads(json.dumps(budget_numbers(made[0])))
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
