"""Rung that names an effect at a raised noise level, at which the mechanism as written follows all records.

The residual of whole records that are followed shows differences that short windows do not. Over a few degrees of the
rotor, neighbouring numbers of periods look alike, and friction over the angle looks like any other friction. The effect
is then grown at the known level.
"""

from __future__ import annotations

from dataclasses import replace

from mechid.identification.effects.settings import DURING_FIT
from mechid.identification.search.solve import solve
from mechid.identification.stages.budget import effects_budget
from mechid.identification.stages.effect_ranking import effect_scores
from mechid.identification.stages.effect_rungs import tune_periods
from mechid.identification.stages.families import Families
from mechid.identification.stages.first_look import fit_look
from mechid.identification.stages.ladder import Climb, Rung
from mechid.identification.stages.settings import STAGES
from mechid.identification.stages.start_growth import grow_at_raised_noise
from mechid.identification.stages.term_growth import grow_model
from mechid.identification.uncertainty.noise import raise_to_residual_levels
from mechid.identification.uncertainty.noise_levels import copy_levels


def _grow_named(climb: Climb) -> Climb:
    """Grow the effects that explain most of the mechanism's residual at a raised level, the best first."""
    assert climb.growth is not None
    watch, known, whole = climb.watch, climb.state.problem, climb.state.problem.whole_windows()
    climb = replace(climb, raised=grow_at_raised_noise(watch, climb.state, climb.growth, climb.seed))
    at, growth = climb.state_at_raised_noise
    if not growth.complete:
        return climb
    q = solve(at.problem, growth.q, whole, steps=STAGES.joint_steps, tolerance=STAGES.rough_tolerance).q
    # The level that followed the records is only a step of the raising; effects are compared at that of the residual.
    problem = replace(known, targets=tuple(raise_to_residual_levels(known, t, q) for t in known.targets))
    q = solve(problem, q, whole, steps=STAGES.joint_steps, tolerance=STAGES.rough_tolerance).q
    families = Families(problem, climb.campaign)
    scores = effect_scores(families, families.bare, q)
    names = sorted(scores, key=lambda name: -scores[name])[: STAGES.grown_at_raised]
    for name in (
        n for n in names if scores[n] > max(STAGES.grown_share * scores[names[0]], DURING_FIT.least_chi_square)
    ):
        watch.tell("whole records", f"{name} explains {scores[name]:.0f} of what a raised noise level hides")
        model = families.with_effect(families.bare, name).lay_out(problem)
        look = fit_look(model, model.point_of(families.bare, q), watch.journal, whole)
        # The look was fitted at the residual's level; growth judges at the known one.
        model = replace(model, problem=copy_levels(model.problem, known))
        reached = grow_model(watch, model, look.q, climb.seed, escapes=STAGES.small_escapes, leaps=STAGES.small_leaps)
        climb = climb.with_growth(tune_periods(climb, climb.families, reached))
        if climb.complete:
            break
    return climb


NAMED_AT_RAISED_LEVEL = Rung(
    "an effect named at a raised noise level",
    lambda climb: climb.may_add and climb.growth is not None and not climb.is_explained,
    _grow_named,
    effects_budget,
)
