"""Disturbances put into a problem and taken out. Truth: the problem as it was."""

import numpy as np
import pytest

from disturbed_bench import written
from mechid.campaign.identify_options import DISTURBANCES
from mechid.identification.effects.campaign_disturbances import possible_disturbances
from mechid.identification.effects.disturbance import remove_disturbances, with_disturbances
from mechid.identification.identify import make_problem
from mechid.identification.output_error.problem import transfer_coordinates


@pytest.fixture(scope="module")
def clock(tmp_path_factory):
    """Return a bench whose recorder runs 400 ppm fast, and the truth."""
    return written(tmp_path_factory.mktemp("clock"), {"clock_ppm": 400.0})


def test_a_disturbance_is_put_in_and_taken_out(clock):
    """Truth: the problem and the point as they were."""
    one, truth = clock
    plain = make_problem(one, 1)
    all_of_them = possible_disturbances(plain, one)
    assert {d.name for d in all_of_them} == set(DISTURBANCES) - {"mains", "record.gain"}
    q = plain.coordinates.point(truth)
    wide = with_disturbances(plain, all_of_them)
    assert wide.size == plain.size + 1 + 3 + 3 + 3 + 3
    here = transfer_coordinates(plain, q, wide)
    for target, own in zip(plain.targets, wide.targets, strict=True):
        np.testing.assert_array_equal(plain.model.predict(target, q, 2000)[0], wide.model.predict(own, here, 2000)[0])
    back, point = remove_disturbances(wide, here, all_of_them)
    assert back.coordinates.names == plain.coordinates.names
    assert back.targets[0].own == plain.targets[0].own
    np.testing.assert_array_equal(point, q)


def test_clocks_of_all_and_of_each_record_add_up(clock):
    """Truth: one clock at their sum; a clock of each record frees what that of all does, and more."""
    one, truth = clock
    plain = make_problem(one, 1)
    clocks = [d for d in possible_disturbances(plain, one) if d.name in ("clock", "record.clock")]
    both = with_disturbances(plain, clocks)
    own = dict.fromkeys(both.coordinates.record_parameter_names, 300.0) | {"campaign.clock_ppm": 100.0}
    alone = with_disturbances(plain, clocks[:1])
    q, sums = both.coordinates.point(truth | own), alone.coordinates.point(truth | {"campaign.clock_ppm": 400.0})
    for target, other in zip(both.targets, alone.targets, strict=True):
        y, expected = both.model.predict(target, q, 2000)[0], alone.model.predict(other, sums, 2000)[0]
        np.testing.assert_array_equal(y, expected)
    assert clocks[1].overlaps(clocks[0])
    assert clocks[1].dof > clocks[0].dof
    assert not any(d.overlaps(clocks[0]) for d in possible_disturbances(plain, one) if d not in clocks)
