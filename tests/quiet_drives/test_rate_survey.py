"""Bands and pairs of rates. Truth: levels typed by hand, and sums of squares by shares of time."""

import numpy as np
import pytest

from mechid.command.phase_table import nominal_table
from mechid.quiet_drives.rate_survey import (
    ALLOWED,
    FORBIDDEN,
    LOST,
    RECOMMENDED,
    SteppingCurve,
    Survey,
    _bands,
    _best_pair,
    _verdict,
    survey,
    widest_bands,
)

RATES = np.array([10.0, 20.0, 30.0, 40.0])


def curve(bound, verdicts=(RECOMMENDED,) * 4):
    bound = np.array(bound)
    return SteppingCurve("micro16", RATES, bound, bound, verdicts)


@pytest.mark.parametrize(
    ("bound", "verdict"), [(0.5, RECOMMENDED), (1.5, ALLOWED), (2.5, FORBIDDEN), (float("nan"), LOST)]
)
def test_a_bound_is_judged_by_quiet_level_and_limit(bound, verdict):
    assert _verdict(bound, 1.0, 2.0) == verdict


def test_neighbouring_rates_of_one_verdict_are_a_band():
    own = curve([1.0, 2.0, 9.0, 1.0], (RECOMMENDED, RECOMMENDED, FORBIDDEN, RECOMMENDED))
    bands = _bands(own)
    assert [(b.verdict, b.low, b.high, b.worst) for b in bands] == [
        (RECOMMENDED, 10.0, 20.0, 2.0),
        (FORBIDDEN, 30.0, 30.0, 9.0),
        (RECOMMENDED, 40.0, 40.0, 1.0),
    ]
    assert widest_bands(Survey((own,), tuple(bands), (), 5.0)) == [bands[0]]


def test_a_loud_mean_rate_is_passed_by_two_quiet_ones():
    pair = _best_pair([curve([3.0, 1.0, 9.0, 2.0])], 30.0)
    assert (pair.low, pair.high, pair.share, pair.alone) == (20.0, 40.0, 0.5, 9.0)
    assert pair.rms == pytest.approx(np.sqrt(0.5 * 1.0 + 0.5 * 4.0))


def test_a_quiet_mean_rate_stays_alone():
    pair = _best_pair([curve([3.0, 1.0, 9.0, 2.0])], 20.0)
    assert (pair.low, pair.high, pair.share) == (20.0, 20.0, 0.0)


def test_a_mean_rate_outside_has_no_pair():
    assert _best_pair([curve([3.0, 1.0, 9.0, 2.0])], 50.0) is None


def test_a_rate_at_which_steps_are_lost_is_named_so(mechanism):
    found = survey([mechanism], {"full": nominal_table(1)}, np.array([30.0, 5000.0]), (), 1.0)
    assert found.curves[0].verdicts[1] == LOST
    assert np.isfinite(found.curves[0].bound[0])
