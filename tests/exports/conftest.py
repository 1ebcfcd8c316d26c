"""Tables of the paper's mechanism at two rates, written once for all tests that read them."""

from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from mechid.command import Command, RateProfile
from mechid.exports.export import Exported, write_export
from mechid.exports.handover import Handover, Trial, handover
from mechid.exports.tables.options import Options
from mechid.identification.result.fit_file import read_fit
from mechid.simulation.simulator import TimeBase
from paper_estimate import write_estimate_of_paper

RATES = (23.0, 46.0)
FULL = Command(stepping="full", microsteps=1, rate=RateProfile.constant(46.0), start_angle_deg=45.0)
SWEEP = Command(stepping="micro", microsteps=16, rate=RateProfile.through([(0.0, 0.0), (0.2, 60.0)]))
BASE = TimeBase(10_000.0, 2001)


@dataclass(frozen=True)
class Tables:
    """What is handed on, and the folder with its tables."""

    what: Handover
    done: Exported

    @property
    def folder(self) -> Path:
        return self.done.folder


@pytest.fixture(scope="session")
def paper(tmp_path_factory):
    """Return what an estimate of the paper's mechanism hands on, with two short records' commands."""
    what = handover(read_fit(write_estimate_of_paper(tmp_path_factory.mktemp("fit"))), None)
    trials = (Trial("full_46", FULL, BASE), Trial("sweep", SWEEP, BASE))
    return replace(what, trials=trials)


@pytest.fixture(scope="session")
def tables(paper, tmp_path_factory):
    """Return the paper's tables at two rates; not to be changed."""
    return Tables(paper, write_export(paper, "tables", tmp_path_factory.mktemp("tables"), Options(rates=RATES)))
