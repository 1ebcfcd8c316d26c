"""Members and estimates made in memory, and the numbers of a fleet."""

from pathlib import Path

import numpy as np
import pytest

import mechid
from estimates import free
from mechid.fleets.estimates import Estimate, Value
from mechid.fleets.members import Member
from mechid.fleets.numbers import fleet_data
from mechid.identification.result.grade import Grade
from synthetic_fleet import Truth, quoted, write_fit, write_fleet_file

HOSTILE = "<img src=x onerror=document.title='taken'>"


@pytest.fixture
def member():
    """Return a function that makes a member."""

    def make(label, **options):
        return Member(source=Path(label), label=label, **{"unit": label, **options})

    return make


@pytest.fixture
def estimate():
    """Return a function that makes an estimate of some parameters, each a value with its error, all in one unit."""

    def make(unit="N m", **parameters):
        values = {
            name: Value(value=v, std_error=e, error=e, unit=unit, status="free", left_out="", near_threshold=False)
            for name, (v, e) in parameters.items()
        }
        return Estimate(grade=Grade.A, said="", values=values, plant="p", version="0")

    return make


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """Return the numbers of 8 units over temperature, before and after, in two lots; one stands off, one has failed."""
    folder, rng, entries = tmp_path_factory.mktemp("fleet"), np.random.default_rng(3), []
    truth = Truth(slopes={"friction.viscous": -0.004})
    for k in range(8):
        unit = truth.unit(rng)
        unit["gear.stiffness"] *= 0.6 if k == 5 else 1.0
        for state in ("before", "after"):
            if state == "after":
                unit["gear.damping"] *= 1.1
            values = truth.estimated(unit, rng, 5.0 * k)
            if k == 0:
                values["stepper.detent.0.amplitude"] = free(0.001, 1e-5, "N m")
            write_fit(folder / f"{k}{state}", values, grade="C" if k == 7 else "A")
            entries.append(
                {
                    "folder": quoted(f"{k}{state}"),
                    "label": quoted(f"FM{k} {HOSTILE if k == 1 else ''} {state}"),
                    "unit": quoted(f"FM{k}"),
                    "state": quoted(state),
                    "group": quoted("AB"[k % 2]),
                    "covariates": f"{{ temperature_degC = {5.0 * k}, date = 2026-01-{1 + k:02d} }}",
                }
            )
    file = write_fleet_file(folder, entries, 'before_after = [["before", "after"]]')
    return fleet_data(mechid.fleet(file, out=folder / "out"), folder / "out")
