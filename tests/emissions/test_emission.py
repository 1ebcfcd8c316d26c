"""An emission with the predictions of a fit. Truth: verdicts made by hand, and the rules of docs/emission.md."""

import numpy as np
import pytest

from mechid.budgets.prediction import Prediction
from mechid.emissions.emission import Assessment, Emission, with_prediction
from mechid.emissions.predicted import PredictedEmission
from mechid.specification.requirement import Mask, Requirement
from mechid.specification.verdict import Judged, Verdict

REQUIREMENT = Requirement(
    name="r", direction="torque", kind="amplitude", mask=Mask(np.array([1.0, 10.0]), np.array([1.0, 1.0]))
)


def judged(verdict):
    return Judged(verdict=Verdict(verdict))


@pytest.mark.parametrize(
    ("measured", "predicted", "verdict"),
    [("pass", "pass", "pass"), ("pass", "fail", "fail"), ("fail", "pass", "fail"), ("not_decidable", "pass", "pass")],
)
def test_the_verdict_is_that_of_records_and_prediction_together(measured, predicted, verdict):
    own = Assessment(requirement=REQUIREMENT, judged=judged(measured), at_rates=(), judged_hz=None)
    found = Emission(
        assessments=(own,), lines=(), spectra=(), backgrounds=(), usable_hz=(1.0, 100.0), notes=("of the records",)
    )
    assert found.passes is (measured == "pass")
    prediction = Prediction(requirement=REQUIREMENT, judged=judged(predicted), notes=("of the requirement",))
    joined = with_prediction(
        found,
        PredictedEmission(
            predictions=(prediction,),
            curves=(),
            place="bench",
            source="fit",
            digest="",
            rates={},
            highest_hz=100.0,
            notes=("of the fit",),
        ),
    )
    assert joined.assessments[0].verdict == verdict
    assert joined.assessments[0].judged.verdict == measured
    assert joined.passes is (verdict == "pass")
    assert joined.notes == ("of the records", "of the fit", "of the requirement")
