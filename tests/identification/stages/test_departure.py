"""What is said of the place where a model leaves a record, on records whose misfit is known."""

import numpy as np
import pytest

from mechid.identification.identify import make_problem
from mechid.identification.stages.departure import departure
from mechid.simulation.simulator import Simulator, TimeBase, simulate_run
from synthetic import COMMANDS, RATE_HZ, bench, displaced, measuring, truth

HORIZON = 4000
SECONDS = 0.8


@pytest.fixture(scope="module")
def problem():
    """Return records of the truth, and the problem of fitting them."""
    start = displaced(truth(), {"gear.stiffness": 1.0, "gear.damping": 1.0})
    return make_problem(bench(start, truth(), "full_23", "micro_92", seed=71, seconds=SECONDS), 1)


def said(problem, name, misfit):
    """Return what is said of a record that departs by a misfit from `HORIZON` on."""
    target = next(t for t in problem.targets if t.name == name)
    time = np.arange(target.samples) / RATE_HZ
    wrong = measuring(target, target.leading.measured + np.where(time > HORIZON / RATE_HZ, misfit(time), 0.0))
    return departure(problem, problem.start, wrong, HORIZON)


@pytest.mark.parametrize(
    ("order", "words"),
    [
        (0.25, "times the step rate, the period of a detent of 7.2 deg, which the model has not"),
        (1.0, "times the step rate, the period of its detent of 1.8 deg and of the steps"),
        (2.3, "times the step rate"),
        (0.51, "times the step rate, which is near the resonance of the load on the gear"),
    ],
)
def test_the_misfit_is_told_in_multiples_of_the_step_rate(problem, order, words):
    """Truth: the sine that was added; 7.2 deg are four full steps of 1.8 deg; sqrt(K_s/J_m) is 46.9 Hz."""
    text = said(problem, "micro_92", lambda time: 0.05 * np.sin(2.0 * np.pi * order * 92.0 * time))
    assert "runs at 92 steps/s" in text
    assert words in text
    assert float(text.split("oscillates at ")[1].split()[0]) == pytest.approx(order, rel=0.03)
    assert "around 0.4 s" in text


def test_a_stick_slip_near_the_horizon_is_named(problem):
    """Truth: the model's own switches under full steps, one of which is put at the horizon."""
    made_by = truth()
    simulator = Simulator(made_by.plant, COMMANDS["full_23"], TimeBase(RATE_HZ, 8001))
    switching = simulate_run(simulator.run(made_by.kernel_values(), substeps=2, events=1000)).switching
    at_s = float(switching.time[switching.time > 0.1][0])
    target = next(t for t in problem.targets if t.name == "full_23")
    text = departure(problem, problem.start, target, round(at_s * RATE_HZ))
    assert f"at {at_s:.4g} s" in text
    assert "friction goes from " in text
