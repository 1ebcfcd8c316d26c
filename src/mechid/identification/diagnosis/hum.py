"""Mains hum that a fit has removed from its records: whether they have it with the effects found since."""

from __future__ import annotations

from mechid.identification.diagnosis.candidate import Model
from mechid.identification.effects.disturbance import MAINS_PREFIX, Disturbance, lines_of, without
from mechid.identification.effects.mains import mains
from mechid.identification.effects.scores import scores
from mechid.identification.effects.selection import is_significant
from mechid.identification.effects.settings import IN_DIAGNOSIS as RULES
from mechid.identification.result.fit import Fit
from mechid.identification.result.missing import Missing


def hum_left(model: Model, fit: Fit) -> list[Missing]:
    """Return the hum that a fit names and its records show beside a model too: steps have lines like the mains'."""
    named = [one for one in fit.missing if one.name.startswith(MAINS_PREFIX)]
    if not named:
        return []
    lines = tuple(lines_of(model.problem))
    removed = Disturbance("", "", lines_hz={t.name: lines for t in model.problem.targets})
    bare, q = without(model.problem, model.q, [removed])
    seen = mains(bare, q)
    if seen is None:
        return []
    score = scores(bare, q, model.setting.windows, [seen])[seen.name]
    return [one for one in named if one.name == seen.name and is_significant(score, RULES)]
