"""`mechid.quiet`. Truth: what the design asked for, and the refusals of docs/quiet.md."""

from dataclasses import replace

import numpy as np
import pytest

import mechid
from mechid.errors import FitError, InputFileError
from mechid.identification.result.grade import Grade


def test_the_design_is_kept_and_filled_in(found):
    assert found.design.rates == (30.0,)
    assert found.table.shape == (32, 2)
    assert np.abs(found.table).max() <= 1.0
    assert found.worst_rise_db < 1.0
    assert [one.rate for one in found.reserves] == [30.0]
    assert found.reserves[0].share >= 0.85
    assert [curve.stepping for curve in found.survey.curves] == ["micro8", "table"]


def test_a_fit_of_grade_c_is_refused_with_the_next_command(fit):
    with pytest.raises(FitError, match="mechid diagnose"):
        mechid.quiet(replace(fit, grade=Grade.C) if "grade" in fit.__dataclass_fields__ else _graded_c(fit), {})


def _graded_c(fit):
    class Worse(type(fit)):
        grade = Grade.C

    return Worse(**{name: getattr(fit, name) for name in fit.__dataclass_fields__})


def test_a_range_that_loses_steps_is_refused_with_its_rate(fit):
    with pytest.raises(FitError, match="at 3000 full steps/s"):
        mechid.quiet(fit, {"rates": [3000.0], "range": {"from": 2999.0, "to": 3001.0}, "microsteps": 2})


def test_a_folder_that_is_not_there_is_named(tmp_path):
    with pytest.raises(InputFileError, match="there is no such folder"):
        mechid.quiet(tmp_path / "fit")
