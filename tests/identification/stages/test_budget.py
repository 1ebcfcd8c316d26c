"""The ladder's end where nothing explains the records. Truth: work as it was counted, and a resumed search."""

from dataclasses import replace

import numpy as np
import pytest

from mechid.identification.computation.journal import Journal
from mechid.identification.identify import identify, make_problem
from mechid.identification.result.grade import NOTHING_EXPLAINS, FitOutcome, Grade
from mechid.identification.stages import budget
from mechid.identification.stages.budget import complete_work
from mechid.identification.stages.ladder import BUDGET_SPENT
from mechid.reports.numbers import report_data
from mechid.simulation.work import work_counter
from synthetic import COMMANDS, campaign, displaced, measured, record, truth

EFFECTS, ALL = 3, 5
"""Budgets here, in complete campaigns: the records' own are not reached by this short one."""


@pytest.fixture(scope="module")
def another():
    """Return records of half steps driven by square waves, which no cosine explains."""
    half = replace(COMMANDS["full_23"], stepping="half", microsteps=2)
    torque = measured(truth(), replace(half, waveform="square"), np.random.default_rng(34), seconds=0.2)
    start = displaced(truth(), {"stepper.torque_constant": 1.1, "gear.stiffness": 1.1, "gear.damping": 0.8})
    return campaign(start, record("half_23", torque, half))


@pytest.mark.slow
def test_a_campaign_that_nothing_explains_ends_at_its_budget_and_says_so_first(another, monkeypatch, tmp_path):
    """Truth: the limit, beside the work before and behind the ladder; a resumed search ends at the same work."""
    monkeypatch.setattr(budget, "STAGES", replace(budget.STAGES, effects_budget=EFFECTS, ladder_budget=ALL))
    path = tmp_path / "journal.jsonl"

    def ended(resume):
        with work_counter() as work:
            fit = identify(another, workers=1, journal=Journal.open(path, {"a": "b"}, resume=resume))
        return fit, work.done

    fit, work = ended(resume=False)
    assert (fit.outcome, fit.grade) == (FitOutcome.HORIZON, Grade.C)
    assert BUDGET_SPENT in fit.warnings
    assert fit.path[:3] == ("as written", "mains hum", "effects named by the first moments")
    assert "records compared, other starts" not in fit.path
    assert work < (ALL + 3) * complete_work(make_problem(another, 1))
    assert report_data(fit)["grade_words"] == NOTHING_EXPLAINS
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join(lines[: 2 * len(lines) // 3]))
    again, resumed = ended(resume=True)
    assert (again.path, again.warnings, resumed) == (fit.path, fit.warnings, work)
    assert {name: p.value for name, p in again.parameters.items()} == {n: p.value for n, p in fit.parameters.items()}
