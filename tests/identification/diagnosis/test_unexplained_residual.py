"""What a diagnosis could not look for in its records is said with why."""

from dataclasses import replace

import numpy as np
import pytest

from mechid.campaign import catalogue_mechanism
from mechid.identification.diagnosis.start import initial_models
from mechid.identification.diagnosis.unexplained_residual import NOT_LOOKED_FOR, explain_untested, untestable_effects
from mechid.identification.effects import scores
from mechid.identification.effects.scores import Landscape
from mechid.identification.identify import identify
from synthetic import COMMANDS, TRUTH, campaign, measured, record


@pytest.fixture(scope="module")
def fitted():
    """Return a model at the optimum of two short records of constant rates that a mechanism as written has made."""
    made_by = catalogue_mechanism().with_values(TRUTH)
    records = [
        record(n, measured(made_by, COMMANDS[n], np.random.default_rng((9, k)), seconds=0.2), COMMANDS[n])
        for k, n in enumerate(("full_46", "micro_46"))
    ]
    bench = campaign(catalogue_mechanism(), *records)
    return initial_models(identify(bench, workers=1, near=TRUTH))[0]


def made(samples, effects):
    """Return a landscape of random derivatives to three free numbers, with effects made from them."""
    rng = np.random.default_rng(4)
    free = rng.standard_normal((20, 3))
    further = {name: make(free, rng) for name, make in effects.items()}
    return Landscape(rng.standard_normal(20), free, further, samples, ("broken",))


def test_effects_that_records_cannot_carry_are_told_apart_by_why():
    """Truth: how the derivatives were made, and the count of what is free beside the effective samples."""
    landscape = made(
        8.0,
        {
            "own": lambda free, rng: rng.standard_normal((20, 2)),
            "like what is free": lambda free, rng: free @ np.array([[1.0, 2.0], [0.5, 0.0], [0.0, -1.0]]),
            "in no record": lambda free, rng: np.zeros((20, 1)),
            "wide": lambda free, rng: rng.standard_normal((20, 5)),
        },
    )
    whys = untestable_effects(landscape)
    assert set(whys) == {"broken", "like what is free", "in no record", "wide"}
    assert all(why.startswith(NOT_LOOKED_FOR) for why in whys.values())
    assert "fails" in whys["broken"]
    assert "5 parameters and the 3 free ones" in whys["wide"]
    assert "8 effective samples" in whys["wide"]
    assert whys["like what is free"] == whys["in no record"]
    assert set(landscape.scores()) == {"own", "like what is free", "in no record"}


def test_friction_by_direction_is_not_looked_for_where_nothing_turns_back(fitted):
    """Truth: both records are commanded one way only, where another friction the other way is no friction at all."""
    assert "do not show it" in explain_untested(fitted, fitted)["friction.directional"]


def test_an_effect_with_which_the_simulation_fails_is_left_out_alone(fitted, monkeypatch):
    """Truth: the scores of all others, each the same whether the failing one is asked for or not."""
    whole, derivatives = fitted.scores(), scores._derivatives
    monkeypatch.setattr(
        scores,
        "_derivatives",
        lambda plain, q, windows, effects, widened: (
            None if "clock" in effects else derivatives(plain, q, windows, effects, widened)
        ),
    )
    # A copy, since a model computes its landscape once.
    again = replace(fitted)
    less = again.landscape
    assert less.failed == ("clock",)
    assert set(less.scores()) == set(whole) - {"clock"}
    for name, score in less.scores().items():
        assert score.chi_square == pytest.approx(whole[name].chi_square, rel=1e-6, abs=1e-6)
    assert "simulation with it fails" in explain_untested(again, again)["clock"]
