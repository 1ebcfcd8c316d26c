"""Readings of all records together: reported, never used."""

import re

import pytest

from mechid.identification.identify import identify, make_problem
from mechid.identification.output_error.declaration import DECLARED
from mechid.identification.readings.all_records import common_readings
from mechid.identification.result.grade import FitOutcome
from mechid.identification.search.gates import Growth
from odd_records import NAMES, made


@pytest.mark.parametrize(
    ("late_s", "told"),
    [(5e-3, True), *(pytest.param(*one, marks=pytest.mark.slow) for one in ((-3e-3, True), (2e-4, False)))],
)
def test_commands_that_begin_late_in_all_records_are_told(late_s, told):
    """Truth: the time offset that made them; one as short is what a filter does, and is looked for as such."""
    problem = make_problem(made("all", late_s=late_s), 1)
    stuck = Growth(problem.start, dict.fromkeys(NAMES, 100), False, 0)
    lines = [line for r in common_readings(problem, stuck, 1) if "time_offset_s" in (line := r.line())]
    assert len(lines) == told
    if told:
        assert float(re.search(r"time_offset_s = (\S+) for each", lines[0])[1]) == pytest.approx(late_s, rel=0.01)
        assert lines[0].startswith("all records: 100 % of their samples are followed with their commands")


@pytest.mark.slow
def test_one_sign_of_all_records_is_told_and_not_taken():
    """Truth: all torques of the other sign under the commands as declared; which of the two it is no record tells."""
    fit = identify(made("all", polarity=-1.0), workers=1)
    assert fit.outcome is FitOutcome.HORIZON
    assert {r.reading for r in fit.records.values()} == {DECLARED}
    assert [w for w in fit.warnings if w.startswith("all records: 100 %") and "gain = -1.0" in w]
