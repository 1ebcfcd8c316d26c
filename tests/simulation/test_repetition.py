"""After how many steps a mechanism may repeat, against what the periods of its parts say."""

import numpy as np
import pytest

from layouts import LAYOUTS, changed, mechanism_of, paper_table
from mechid.plant.flight import to_flight
from mechid.simulation.repetition import repetition


def detent(period_deg):
    return {"stepper": {"detent": [{"period_deg": period_deg, "amplitude": 0.004}]}}


def error(order):
    return {"gear": {"kinematic_error": [{"order": order, "amplitude": 1e-4}]}}


def harmonic(order):
    return {"stepper": {"torque_harmonic": [{"order": order, "amplitude": 0.05}]}}


@pytest.mark.parametrize(
    ("changes", "steps", "mirrored"),
    [
        ({}, 2, True),  # half an electrical period, currents reversed
        (detent(1.8), 2, True),
        (detent(3.6), 2, True),
        (detent(7.2), 4, False),  # one period in an electrical period: the other way round after half of it
        (detent(14.4), 8, False),
        (detent(2.5), 50, True),
        (detent(2.5001), 0, True),  # never within ten turns
        (error(1), 200, False),
        (error(2), 100, False),
        (error(4), 50, True),
        (error(50), 4, False),
        (harmonic(3), 2, True),
        (harmonic(2), 4, False),
        (LAYOUTS["imbalance"], 4, False),  # a voltage offset does not turn with the currents
        ({"stepper": {"imbalance": {"resistance": 0.02, "torque_constant": 0.03}}}, 2, True),
        (LAYOUTS["friction position"], 0, True),  # the output turns once in 10 000 steps
        (LAYOUTS["lugre"], 2, True),
        (LAYOUTS["three switches"], 2, True),
        (LAYOUTS["load_dependent"], 2, True),
        (LAYOUTS["flexible load"], 2, True),
        (LAYOUTS["microstep table"], 2, True),
        (LAYOUTS["supply"], 2, True),
        (LAYOUTS["saliency"], 2, True),
        (LAYOUTS["detent hysteresis"], 2, True),
    ],
)
def test_steps_after_which_it_may_repeat(changes, steps, mirrored):
    """Truth: 200 full steps a turn of 1.8 deg, four an electrical period; a part repeats in its own."""
    mechanism = to_flight(mechanism_of(changed(paper_table(), changes)))
    found, angle = repetition(mechanism), [str(s) for s in mechanism.plant.states].index("alpha")
    assert found.steps == steps
    assert (found.sign.min() < 0.0) == (mirrored and "current" not in str(changes))
    turned = (steps or 2) * np.pi / 100.0
    assert found.turn[angle] == pytest.approx(turned)
    assert found.whole[angle] == pytest.approx(turned * (2 if mirrored else 1))


def test_no_longer_than_asked():
    mechanism = to_flight(mechanism_of(changed(paper_table(), error(1))))
    assert repetition(mechanism, 199.0).steps == 0
    assert repetition(mechanism, 200.0).steps == 200


@pytest.mark.parametrize(
    ("changes", "steps"),
    [({}, 2), (detent(7.2), 4), (error(2), 100), ({"anti_alias": {"frequency": 3000.0, "order": 4}}, 2)],
)
def test_a_mechanism_on_the_bench_repeats_as_the_one_in_flight(changes, steps):
    """Truth: housing, transducer and filters are linear and behind the mechanism, so that they repeat with it."""
    assert repetition(mechanism_of(changed(paper_table(), changes))).steps == steps
