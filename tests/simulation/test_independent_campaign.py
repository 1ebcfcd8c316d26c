"""Records of ../shared/campaign/exact, made by another program with the paper's equations.

Truth: that program (RK4 in 16 substeps, stick/slip by bisection); agreement to 1e-5 of each record's RMS torque.
"""

import tomllib

import numpy as np
import pytest

from mechid.command import Command
from mechid.simulation.accuracy import simulate_accurately
from mechid.simulation.simulator import TimeBase
from paper import ESTIMATED
from paper import mechanism as paper_mechanism
from runs import rms, simulator

RECORDS = ("full_res", "full_half", "full_slow", "micro_res", "micro_2res", "sweep")


def flattened(table, prefix=""):
    """Return {dotted name: number} of a mechanism file."""
    items = enumerate(table) if isinstance(table, list) else table.items()
    out = {}
    for key, value in items:
        name = f"{prefix}{key}"
        out |= flattened(value, f"{name}.") if isinstance(value, dict | list) else {name: value}
    return out


@pytest.fixture(scope="module")
def exact(campaign_folder):
    """Return the mechanism, and the table of each record by name."""
    folder = campaign_folder / "exact"
    values = flattened(tomllib.loads((folder / "mechanism.toml").read_text()))
    values.setdefault("stepper.back_emf_constant", values["stepper.torque_constant"])
    assert values.keys() <= ESTIMATED.keys()
    records = tomllib.loads((folder / "campaign.toml").read_text())["record"]
    return folder, paper_mechanism(changes=values), {r["name"]: r for r in records}


@pytest.mark.parametrize("name", RECORDS)
def test_it_is_reproduced(exact, name, note):
    folder, m, records = exact
    command = Command.from_table(records[name]["command"], name, folder)
    time, torque = np.loadtxt(folder / records[name]["file"], delimiter=",", skiprows=1, unpack=True)
    time_base = TimeBase(1.0 / (time[1] - time[0]), time.size, time[0])
    run = simulate_accurately(simulator(m, command, time_base), m.kernel_values())
    error = rms(run.torque - torque) / rms(torque)
    note(f"{name}: RMS error {error:.1e} of {rms(torque):.3f} N m, {run.substeps} steps a sample")
    assert error <= 1e-5
