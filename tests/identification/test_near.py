"""An identification from values that are near already: no search, and what they leave of the records is noise."""

from dataclasses import replace

import pytest

from coloured import FREE, NEAR, assert_true, coloured
from mechid.identification.identify import identify
from mechid.identification.result.grade import FitOutcome
from synthetic import AS_WRITTEN, NOISE_NM, bench, campaign, displaced, truth


def test_it_ends_where_the_search_ends():
    """Truth: the optimum that the search finds from a start some way off, to a hundredth of a standard error."""
    start = displaced(truth(), dict.fromkeys(FREE, 1.3))
    records = bench(start, truth(), "full_46", "micro_46", seed=9, seconds=0.3)
    searched, near = identify(records), identify(records, near=NEAR)
    assert [s.name for s in near.stages] == ["joint fit", "noise re-estimated"]
    assert near.outcome is FitOutcome.CONVERGED
    for name in FREE:
        p = searched.parameters[name]
        assert near.parameters[name].value == pytest.approx(p.value, abs=0.01 * p.std_error), name


def test_noise_is_what_is_left_also_where_it_is_coloured():
    """Truth: the values that made the records, within 5 sigma; the noise's floor is ten times too low here."""
    records = coloured(12, hertz=888.0, radius=0.9, samples=3001)
    made = replace(campaign(displaced(truth(), dict.fromkeys(FREE, 1.3)), *records), options=AS_WRITTEN)
    assert_true(identify(made, near=NEAR))


@pytest.mark.slow
def test_a_quiet_stretch_tells_the_search_how_loud_coloured_noise_is():
    """Truth: the values that made the records, within 5 sigma, from a start some way off; the floor alone misleads."""
    quiet = {"step": "quiet", "text": "", "channel": "torque", "rms": NOISE_NM}
    heard = coloured(14, hertz=888.0, radius=0.9, samples=4001)
    told = [replace(r, data=replace(r.data, treatments=(quiet,))) for r in heard]
    fit = identify(campaign(displaced(truth(), dict.fromkeys(FREE, 1.2)), *told))
    assert_true(fit)
    assert all(r.prefilter_order >= 2 for r in fit.records.values())


@pytest.mark.slow
def test_a_narrow_resonance_in_the_noise_is_whitened_until_it_is_white():
    """Truth: the AR(2) process added, and the values that made the records, within 5 sigma.

    Weighted by sample alone the first fit errs by more than the process's own innovation, 200 times below its RMS:
    the filter of what that leaves is not the noise's, and the errors behind it are not those of white noise.
    """
    records = coloured(13, hertz=46.0, radius=0.99, samples=4001, settled=10_000)
    fit = identify(campaign(displaced(truth(), dict.fromkeys(FREE, 1.3)), *records), near=NEAR)
    assert_true(fit)
    assert "whitened again" in [s.name for s in fit.stages]
    assert [r.prefilter_order for r in fit.records.values()] == [2, 2]
    for name in NEAR:
        p = fit.parameters[name]
        assert p.std_error == pytest.approx(p.std_error_white, rel=0.05), name
