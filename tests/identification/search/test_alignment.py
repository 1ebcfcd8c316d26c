"""Delays set by the first motion. Truth: the instants at which the commands of synthetic records begin."""

from dataclasses import replace

import numpy as np
import pytest

from mechid.identification.identify import make_problem
from mechid.identification.search.alignment import align_all_first_motions, align_first_motion, realign
from mechid.identification.search.first_moments import first_residual, robust_cost
from synthetic import COMMANDS, RATE_HZ, campaign, displaced, measured, record, truth

WIDE, NARROW = {"value": 0.5, "min": 0.42, "max": 0.58}, {"value": 0.0, "min": -0.002, "max": 0.002}
STARTS_S = {"full_46": 0.52, "full_23": 0.481, "micro_46": 0.5, "micro_92": 0.455}
FACTORS = {"stepper.torque_constant": 1.3, "gear.stiffness": 0.7, "stepper.coil_inductance": 1.5}


def made(mechanism, offset, starts_s):
    """Return the problem of records whose commands begin at these instants, declared as `offset`."""
    records = []
    for number, (name, start_s) in enumerate(starts_s.items()):
        rng = np.random.default_rng((7, number))
        y = measured(truth(), COMMANDS[name], rng, seconds=start_s + 0.3, time_offset_s=start_s)
        records.append(record(name, y, COMMANDS[name], time_offset=offset))
    return make_problem(campaign(mechanism, *records), 1)


def delays(problem, q):
    return {
        c.parameter.name.split(".")[1]: v for c, v in zip(problem.coordinates.own, q[problem.space.size :], strict=True)
    }


@pytest.fixture(scope="module")
def scattered():
    return made(displaced(truth(), dict.fromkeys(FACTORS, 1.0)), WIDE, STARTS_S)


def test_the_true_mechanism_moves_when_the_records_do(scattered):
    """Truth: the first motion is told by the noise to a few samples of 0.1 ms."""
    q = align_all_first_motions(scattered, scattered.start)
    for name, found in delays(scattered, q).items():
        assert found == pytest.approx(STARTS_S[name], abs=1e-3), name


def test_a_catalogue_that_is_wrong_by_factors_moves_within_a_few_milliseconds(scattered):
    """Truth: a period of the resonance is 21 ms; of the trigger's 20 ms no more than an eighth of it is left."""
    wrong = made(displaced(truth(), FACTORS), WIDE, STARTS_S)
    for name, found in delays(wrong, align_all_first_motions(wrong, wrong.start)).items():
        assert found == pytest.approx(STARTS_S[name], abs=2.6e-3), name


def test_an_aligned_start_costs_a_hundredth(scattered):
    target = scattered.targets[0]
    (aligned,) = align_first_motion(scattered, target, [scattered.start])
    before, after = (robust_cost(first_residual(scattered, target, q)) for q in (scattered.start, aligned))
    assert after < 0.01 * before


def test_points_are_aligned_one_by_one(scattered):
    """Truth: each point by itself."""
    target = scattered.targets[1]
    points = [scattered.start + h for h in (0.0, 0.1, 0.2)]
    for point in points:
        point[scattered.space.size :] = scattered.start[scattered.space.size :]
    together = align_first_motion(scattered, target, points)
    alone = [align_first_motion(scattered, target, [point])[0] for point in points]
    np.testing.assert_allclose(together, alone, atol=1.5 / RATE_HZ)


def test_a_delay_outside_its_bounds_ends_there():
    problem = made(truth(), WIDE | {"max": 0.51}, {"full_46": 0.52})
    assert delays(problem, align_all_first_motions(problem, problem.start))["full_46"] == pytest.approx(0.51)


@pytest.mark.parametrize("offset", [NARROW, None])
def test_what_is_known_of_a_trigger_is_kept(offset):
    problem = made(truth(), offset, {"full_46": 0.0})
    np.testing.assert_array_equal(align_all_first_motions(problem, problem.start), problem.start)


def test_a_record_that_never_moves_is_left_alone(scattered):
    target = scattered.targets[0]
    leading = replace(target.leading, measured=np.zeros(target.samples))
    still = replace(target, channels=(leading,))
    (q,) = align_first_motion(scattered, still, [scattered.start])
    np.testing.assert_array_equal(q, scattered.start)


@pytest.mark.parametrize("off_s", [-0.05, -0.017, 0.03, 0.06])
def test_a_delay_that_is_far_off_is_found_anew(scattered, off_s):
    """Truth: the instant at which the command begins; derivatives lead on from half a millisecond."""
    q = align_all_first_motions(scattered, scattered.start)
    place = scattered.coordinates.names.index("record.micro_92.time_offset_s")
    moved = q.copy()
    moved[place] += off_s
    moved[place] = np.clip(moved[place], WIDE["min"], WIDE["max"])
    found = realign(scattered, moved)
    assert found[place] == pytest.approx(STARTS_S["micro_92"], abs=1e-3)
    np.testing.assert_array_equal(np.delete(found, place), np.delete(moved, place))


def test_a_delay_that_is_right_stays_to_the_bit(scattered):
    q = align_all_first_motions(scattered, scattered.start)
    np.testing.assert_array_equal(realign(scattered, q), q)


@pytest.mark.parametrize("offset", [NARROW, None])
def test_a_known_trigger_is_not_sought_anew(offset):
    problem = made(truth(), offset, {"full_46": 0.0})
    np.testing.assert_array_equal(realign(problem, problem.start), problem.start)
