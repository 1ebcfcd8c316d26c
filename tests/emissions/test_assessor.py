"""Stretches, rates and bands of records. Truth: the commands and the sample rate."""

import pytest

import mechid
from emission_bench import background, record, requirement, samples, write_campaign

LINES = ((46.0, 0.05), (92.0, 0.02))


def judged(folder, *wanted, lines=LINES, beside=(), seconds=8.0):
    runs = {"run": samples(1, (*lines, *beside)), "off": samples(2, beside, seconds)}
    return mechid.emission(write_campaign(folder, runs, record("run", 46.0), background(), *wanted))


def test_a_sweep_is_judged_in_stretches_at_their_own_rates(tmp_path):
    write_campaign(
        tmp_path,
        {"run": samples(1), "off": samples(2)},
        record("run", 46.0).replace("rate = 46.0", "rate_profile = [[0.0, 0.0], [8.0, 80.0]]"),
        background(),
        requirement(),
    )
    found = mechid.emission(tmp_path)
    assert [at.rate for at in found.assessments[0].at_rates] == pytest.approx([10.0, 30.0, 50.0, 70.0])


def test_a_part_of_the_mask_that_the_record_does_not_show_is_named(tmp_path):
    found = judged(tmp_path, requirement(mask=((20.0, 0.1), (5000.0, 0.1))))
    assert found.assessments[0].judged_hz == pytest.approx((20.0, 2000.0 / 2.56))
    assert any("not judged is its mask at 781.2 to 5000 Hz" in note for note in found.notes)


@pytest.mark.parametrize("kind", ["rms", "band_peak"])
def test_a_band_that_the_record_holds_in_part_is_named_and_not_judged(tmp_path, kind):
    """Truth: the record ends at 781 Hz, within the second band of the mask, which is then no part of the verdict."""
    mask = ((20.0, 10.0), (500.0, 1e-9), (1000.0, 1e-9))
    found = judged(tmp_path, requirement(kind=kind, mask=mask))
    assert found.assessments[0].verdict == "pass"
    assert found.assessments[0].judged_hz == pytest.approx((20.0, 500.0))
    assert any("not judged is its mask at 500 to 1000 Hz" in note for note in found.notes)


def test_rates_outside_the_ranges_are_not_judged(tmp_path):
    found = judged(tmp_path, requirement(more="rates = [[60.0, 80.0]]"))
    assert found.assessments[0].verdict == "not_decidable"
    assert any("no record has a step rate in its rates" in note for note in found.notes)
