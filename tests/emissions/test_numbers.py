"""Numbers of an emission verdict. Truth: JSON knows no NaN, and the definitions of the requirement's kind."""

import json

import numpy as np

from mechid.emissions.emission import Assessment, AtRate, Emission
from mechid.emissions.numbers import emission_numbers
from mechid.specification.requirement import Mask, Requirement
from mechid.specification.verdict import Judged, Verdict, Worst

WORST = Worst(
    record="a",
    rate=np.nan,
    frequency_hz=46.0,
    value=0.0,
    sigma=1e-3,
    limit=0.1,
    lower=0.0,
    upper=0.01,
    background=0.0,
    margin_db=np.inf,
)


def test_what_is_not_known_is_null():
    wanted = Requirement(
        name="r", direction="mz", kind="psd", mask=Mask(np.array([1.0, 2.0]), np.ones(2)), resolution_hz=0.5
    )
    judged = Judged(verdict=Verdict.PASS, worst=WORST)
    at = (AtRate(record="a", rate=np.nan, judged=judged),)
    found = Emission(
        assessments=(Assessment(requirement=wanted, judged=judged, at_rates=at, judged_hz=None),),
        lines=(),
        spectra=(),
        backgrounds=(),
        usable_hz=(1.0, 400.0),
    )
    data = json.loads(json.dumps(emission_numbers(found), allow_nan=False))
    (one,) = data["requirements"]
    assert one["worst"]["rate"] is None
    assert one["worst"]["margin_dB"] is None
    assert one["unit"] == "N^2*m^2/Hz"
    assert "bins of 0.5 Hz" in one["definition"]
