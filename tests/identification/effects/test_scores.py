"""Score test of effects. Truth: the effect that made the records."""

import pytest

from disturbed_bench import written
from mechid.identification.effects.campaign_disturbances import possible_disturbances
from mechid.identification.effects.scores import scores
from mechid.identification.identify import make_problem


@pytest.fixture(scope="module")
def clock(tmp_path_factory):
    """Return a bench whose recorder runs 400 ppm fast, and the truth."""
    return written(tmp_path_factory.mktemp("clock"), {"clock_ppm": 400.0})


def test_the_score_tells_which_it_is(clock):
    """Truth: the recorder's clock, at the true values of all else; and that lines are not more than chance there."""
    one, truth = clock
    plain = make_problem(one, 1)
    q = plain.coordinates.point(truth)
    found = scores(plain, q, plain.whole_windows(), possible_disturbances(plain, one, q))
    assert max(found, key=lambda name: found[name].excess) == "clock"
    assert {name: score.dof for name, score in found.items()} == {
        "clock": 1,
        "record.clock": 3,
        "record.delay": 3,
        "record.voltage": 2,
        "record.temperature": 2,
    }
    assert found["clock"].share > 0.5
