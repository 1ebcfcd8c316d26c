"""What several tests of budgets begin with: the paper's mechanism as it flies, its steady torque, a small budget."""

import json
from dataclasses import replace

import numpy as np
import pytest

from mechid.budgets.document import PRESENTER
from mechid.budgets.flight_entry import Flight
from mechid.budgets.flying_mechanism import flying_estimate
from mechid.budgets.numbers import budget_numbers
from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.steady_state import steady_state
from mechid.command import Command, RateProfile
from mechid.identification.result.estimate_file import json_text
from mechid.identification.result.fit_file import read_fit
from mechid.simulation.simulator import Simulator, TimeBase, simulate_run
from once import once
from paper_estimate import write_estimate_of_paper
from small_budget import small_budget

MICRO = Command(stepping="micro", microsteps=16, rate=RateProfile.constant(37.3))
MODE = OperatingMode(name="scan", command=MICRO, rates=np.array([37.3]), settle_s=1.0, highest_hz=300.0)


@pytest.fixture(scope="session")
def flying(tmp_path_factory):
    """Return what flies of the paper's estimate."""
    return flying_estimate(read_fit(write_estimate_of_paper(tmp_path_factory.mktemp("estimate"))), Flight())


@pytest.fixture(scope="session")
def state(flying, tmp_path_factory):
    """Return the steady state of microsteps at 37.3 steps/s, with derivatives to all that is estimated."""
    return once(tmp_path_factory, "steady_state", lambda: steady_state(flying.mechanism, MODE, 37.3, flying.names, 4))


@pytest.fixture(scope="session")
def long_run(flying, tmp_path_factory):
    """Return 5 s of the same torque at 20 kHz, another sample rate than the lines are made at."""

    def run():
        simulator = Simulator(flying.mechanism.plant, MICRO, TimeBase(20_000.0, 100_001))
        return simulate_run(simulator.run(flying.mechanism.kernel_values(), substeps=2)).torque

    return once(tmp_path_factory, "long_run", run)


@pytest.fixture(scope="session")
def made(tmp_path_factory):
    """Return the small budget; not to be changed."""
    return small_budget(tmp_path_factory)


@pytest.fixture(scope="session")
def data(made):
    """Return every number of the small budget; not to be changed."""
    return json.loads(json_text(budget_numbers(made)))


@pytest.fixture(scope="session")
def write_report():
    """Return what writes page, Markdown and figures of a budget's numbers into a folder."""
    shown = replace(PRESENTER, texts=lambda *_: {}, files=lambda *_: [])
    return lambda data, folder: shown.write(None, data, folder)


@pytest.fixture(scope="session")
def report(data, write_report, tmp_path_factory):
    """Return the folder of the small budget's page; not to be changed."""
    out = tmp_path_factory.mktemp("report")
    write_report(data, out)
    return out
