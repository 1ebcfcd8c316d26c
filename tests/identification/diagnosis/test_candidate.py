"""The walk of an effect of each kind through a model. Truth: the model as it was, and the effect that was put in."""

import tomllib
from dataclasses import replace

import numpy as np
import pytest

from mechid.campaign.mechanism_file import load_mechanism
from mechid.campaign.mechanism_text import mechanism_text
from mechid.identification.diagnosis.proposal import build_proposal
from mechid.identification.diagnosis.start import initial_models
from mechid.identification.diagnosis.steps import has_absent_law, score_law
from mechid.identification.effects.effect import distance_from_null
from mechid.identification.effects.selection import (
    add_likeliest,
    drop_unneeded,
    is_confirmed,
    is_significant,
    likely_effects,
)
from mechid.identification.identify import identify
from synthetic import TRUTH, bench, displaced, truth

TERM, LAW, DISTURBANCE = "stepper.torque_harmonic:3", "output_friction", "clock"
SIZES = {TERM: 0.02, LAW: 0.01, DISTURBANCE: 250.0}
KINDS = pytest.mark.parametrize("effect", [TERM, LAW, DISTURBANCE])


@pytest.fixture(scope="module")
def plain():
    """Return the model of two short records that the mechanism as written follows."""
    made = bench(displaced(truth(), {"gear.stiffness": 1.001}), truth(), "full_46", "micro_46", seed=5, seconds=0.2)
    before, _ = initial_models(identify(made, workers=1, near=TRUTH))
    return before.fit(before)


def effect_parameter_names(model, effect):
    return model.law_parameters if effect == LAW else model.parameters[effect]


def measured_with(model, effect):
    """Return a model whose records hold an effect of a known size, made by itself without noise."""
    wide = model.add_effect(effect)
    values = model.problem.coordinates.values(model.q)
    free = {
        name: SIZES[effect]
        for name in effect_parameter_names(wide, effect)
        if not name.endswith(("phase_deg", "stiction"))
    }
    at = wide.at({**values, **free})
    rng = np.random.default_rng(1)
    targets = []
    for plain_target, target in zip(model.setting.problem.targets, at.problem.targets, strict=True):
        (y,) = at.problem.model.predict(target, at.q, target.samples)
        y = y + plain_target.leading.sigma * rng.standard_normal(y.size)
        leading = replace(plain_target.leading, measured=y)
        targets.append(replace(plain_target, channels=(leading, *plain_target.channels[1:])))
    problem = replace(model.setting.problem, targets=tuple(targets))
    return replace(model, setting=replace(model.setting, problem=problem)).at(values)


@pytest.mark.parametrize("effect", [*(pytest.param(one, marks=pytest.mark.slow) for one in (TERM, LAW)), DISTURBANCE])
def test_an_effect_enters_a_model_and_leaves_it(plain, effect):
    """Truth: at its null value it changes nothing; without it, the problem is the same to the last bit."""
    wide = plain.add_effect(effect)
    assert effect in wide.effects
    assert wide.problem.size > plain.problem.size
    there = wide.move_to(plain)
    own = [name in effect_parameter_names(wide, effect) for name in wide.problem.coordinates.names]
    if effect != LAW:  # a law has no null value
        assert there.cost == pytest.approx(plain.cost, rel=1e-9)
        assert np.all(distance_from_null(wide.problem, there.q)[own] == 0.0)
    less = there.remove_effect(effect)
    assert less.problem.coordinates.names == plain.problem.coordinates.names
    assert less.problem.norms(plain.q, plain.setting.windows) == plain.problem.norms(plain.q, plain.setting.windows)


@pytest.mark.slow
@KINDS
def test_an_effect_is_scored_selected_kept_and_declared(plain, effect, tmp_path):
    """Truth: the size with which the records were made."""
    model = measured_with(plain, effect)
    model = model.fit(model)
    if effect == LAW:
        law = next(law for law in model.other_laws if law.name == LAW)
        assert is_significant(score_law(model, law)[0], model.rules, model.rules.share)
        more = model.with_effect(effect)
    else:
        assert likely_effects(model, model.scores())[0] == effect
        more = add_likeliest(model, {})
    assert more.effects == (effect,)
    assert is_confirmed(model, more)
    idle = next(name for name in (DISTURBANCE, TERM) if name != effect)
    both = more.add_effect(idle).fit(more)
    (dropped,) = [name for name, _ in drop_unneeded(both, both.effects)]
    assert dropped == idle
    proposal = build_proposal(more)
    assert tomllib.loads("\n".join(line for line in proposal.tomls[effect].splitlines() if not line.startswith("#")))
    own = {name.rpartition(".")[2]: p.value for name, p in proposal.own[effect].items()}
    assert any(abs(value) == pytest.approx(SIZES[effect], rel=0.2) for value in own.values())
    (tmp_path / "proposed.toml").write_text(mechanism_text(proposal.mechanism))
    back = load_mechanism(tmp_path / "proposed.toml")
    assert {p.name for p in proposal.mechanism.free} <= set(back.parameters)


@pytest.mark.parametrize(("share", "absent"), [(0.0, True), (0.005, True), (0.1, False)])
def test_a_play_at_its_lower_bound_is_no_effect(plain, share, absent):
    """Truth: the bounds of a play; its fit may end at the lower one, with the rounding of impacts as its only gain."""
    law = next(one for one in plain.other_laws if one.name == "gear.backlash")
    play = law.mechanism.parameters["gear.backlash"]
    values = plain.problem.coordinates.values(plain.q)
    at = plain.use_law(law, law.mechanism).at({**values, play.name: play.min * (1.0 + share)})
    assert has_absent_law(at) is absent
    assert not has_absent_law(plain)
