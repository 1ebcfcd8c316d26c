"""Effects found as far as records are followed. Truth: the effect that made them."""

from dataclasses import replace

import numpy as np
import pytest

from diagnosis_bench import HARMONIC, made
from mechid.identification.diagnosis.diagnosis import diagnose
from mechid.identification.diagnosis.start import initial_models
from mechid.identification.diagnosis.stretches import search_by_growth
from mechid.identification.result.grade import Grade
from synthetic import RATE_HZ


def test_effects_are_found_from_the_first_moments_on(fitted):
    """Truth: the harmonic that made the records, five times that of the fit's, whose values are none of these."""
    bench = made({**HARMONIC, "amplitude": 0.05})
    before, _ = initial_models(replace(fitted[1], campaign=bench))
    told = []
    found = search_by_growth(replace(before, q=before.problem.start, cost=np.inf), told.append)
    assert found.effects == ("stepper.torque_harmonic:3",)
    assert found.over_noise == pytest.approx(1.0, abs=0.03)
    assert found.is_of_whole_records
    values = found.problem.coordinates.values(found.q)
    (amplitude,) = (v for n, v in values.items() if "torque_harmonic" in n and n.endswith("amplitude"))
    assert amplitude == pytest.approx(0.05, rel=0.05)
    assert told[0].endswith("% of the records followed with nothing added")
    assert told[-1] == "100.0 % of the records followed with stepper.torque_harmonic:3"


def backwards_after(bench, seconds):
    """Return a campaign whose records run backwards after some time, which no mechanism follows."""
    first = round(seconds * RATE_HZ)

    def one(made_record):
        (channel,) = made_record.data.channels
        torque = np.array(channel.data)
        torque[first:] = torque[first:][::-1]
        return replace(made_record, data=replace(made_record.data, channels=(replace(channel, data=torque),)))

    return replace(bench, records=tuple(map(one, bench.records)))


@pytest.mark.slow
def test_what_is_missing_is_named_from_what_can_be_followed(fitted):
    """Truth: the harmonic that made the records up to 0.2 s of 0.3; nothing made what comes after that."""
    bench = backwards_after(made({**HARMONIC, "amplitude": 0.05}), 0.2)
    found = diagnose(replace(fitted[1], campaign=bench, grade=Grade.C, reasons=()), workers=1)
    assert [one.name for one in found.missing] == ["stepper.torque_harmonic:3"]
    assert 0.6 < found.share < 0.7
    assert f"the first {100.0 * found.share:.3g} % of all samples" in found.words
    (amplitude,) = (p for n, p in found.missing[0].parameters.items() if n.endswith("amplitude"))
    assert abs(amplitude.value - 0.05) < 4.0 * amplitude.std_error
