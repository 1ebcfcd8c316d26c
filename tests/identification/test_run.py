"""A mechanism is completed by what a diagnosis names, and searched again where the completed one does not follow."""

from dataclasses import dataclass
from types import SimpleNamespace

import pytest

import mechid
from diagnosis_bench import HARMONIC, made
from mechid.identification import run
from mechid.identification.diagnosis import diagnosis
from mechid.identification.result.grade import FitOutcome, Grade
from synthetic import TRUTH


@dataclass(frozen=True)
class Fitted:
    """What a completion asks of a fit."""

    grade: Grade
    outcome: FitOutcome = FitOutcome.CONVERGED
    completed: tuple = ()


@pytest.mark.parametrize(
    ("outcome", "share", "asked"),
    [
        (FitOutcome.CONVERGED, 1.0, [False]),
        (FitOutcome.HORIZON, 1.0, [False]),
        (FitOutcome.HORIZON, 0.4, [False, True]),
        (FitOutcome.INTERRUPTED, 1.0, [False]),
    ],
)
def test_a_completion_searches_patiently_only_where_no_model_follows(outcome, share, asked, monkeypatch):
    """Truth: the order that the documentation gives; searches and diagnoses are stand-ins."""
    searches = []

    def search(_, *, patient=True, **__):
        searches.append(patient)
        return SimpleNamespace(outcome=outcome, grade="C", patient=patient)

    monkeypatch.setattr(run, "search", search)
    monkeypatch.setattr(diagnosis, "diagnose", lambda *_, **__: SimpleNamespace(mechanism=object(), share=share))
    fit, found = run.search_and_diagnose(None, run.IdentifyRun(), run.Companion())
    assert searches == asked
    assert fit.patient is asked[-1]
    assert (found is None) == (outcome is FitOutcome.INTERRUPTED)


@pytest.mark.parametrize(("grades", "kept"), [("A", "A"), ("CA", "A"), ("CB", "B"), ("CC", "C")])
def test_a_completed_fit_that_is_not_followed_is_searched_again(grades, kept, monkeypatch):
    """Truth: the order that the documentation gives; searches are stand-ins, the second one begins from no values."""
    begun_near, left = [], iter(grades)

    def search(_, *, near=None, **__):
        begun_near.append(near)
        return Fitted(grade=Grade(next(left)))

    monkeypatch.setattr(run, "search", search)
    whole = SimpleNamespace(mechanism=SimpleNamespace(free=[SimpleNamespace(name="a", value=1.0)]))
    fit = run.fit_completed_mechanism(whole, SimpleNamespace(share=1.0, steps=()), run.IdentifyRun())
    assert fit.grade == kept
    assert begun_near == [{"a": 1.0}, None][: len(grades)]


@pytest.mark.slow
def test_a_mechanism_completes_itself():
    """Truth: the harmonic and the parameters that made the records."""
    fit = mechid.identify(made(HARMONIC), workers=1, near=TRUTH, complete=True)
    assert fit.grade == "A"
    assert [step["added"] for step in fit.completed] == ["stepper.torque_harmonic:3"]
    own = fit.parameters["stepper.torque_harmonic.0.amplitude"]
    assert abs(own.value - 0.01) < 4.0 * own.std_error
    assert mechid.identify(made(), workers=1, near=TRUTH, complete=True).completed == ()
