"""Members and estimates made in memory."""

from pathlib import Path

import pytest

from mechid.fleets.estimates import Estimate, Value
from mechid.fleets.members import Member
from mechid.identification.result.grade import Grade


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
