"""Proposal of a diagnosis: the mechanism with the effects found, its hum, its prediction of held-out records."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mechid.campaign.mechanism_text import appendix_text
from mechid.identification.diagnosis.candidate import Model
from mechid.identification.effects.disturbance import MAINS_PREFIX, Disturbance, lines_of, without
from mechid.identification.effects.mains import mains
from mechid.identification.effects.scores import by_own_residuals, scores
from mechid.identification.effects.selection import is_significant
from mechid.identification.effects.settings import IN_DIAGNOSIS as RULES
from mechid.identification.identify import make_problem
from mechid.identification.result.as_fitted import campaign_as_fitted
from mechid.identification.result.fit import Fit
from mechid.identification.result.missing import Missing, OwnValue
from mechid.identification.search.solve import covariance
from mechid.plant.mechanism import Mechanism
from mechid.plant.superset import superset_of


@dataclass(frozen=True, eq=False)
class Proposal:
    """A mechanism with the effects of a model, and where each of these stands in it.

    Attributes
    ----------
    mechanism : Mechanism
        At the model's values; effects free.
    own : mapping of str to mapping of str to OwnValue
        Parameters of each effect by the names that they have in the file, by the effect's name.
    tomls : mapping of str to str
        What declares each effect by itself at the end of the file, or of the campaign file.
    """

    mechanism: Mechanism
    own: dict[str, dict[str, OwnValue]]
    tomls: dict[str, str]


def proposal_of(model: Model) -> Proposal:
    """Return what a model proposes."""
    values, errors = _found(model)
    superset = superset_of(model.base, only=model.terms, further=model.further) if model.terms else None
    mechanism = superset.with_free_terms(model.terms) if superset else model.base
    renamed = _renamed(model, superset.term_of if superset else {})
    here = {renamed.get(name, name): value for name, value in values.items()}
    mechanism = mechanism.with_values({n: v for n, v in here.items() if n in mechanism.parameters})
    own: dict[str, dict[str, OwnValue]] = {}
    for effect, names in _names(model).items():
        own[effect] = {
            renamed.get(name, name): OwnValue(value=values[name], std_error=errors[name], unit=_unit(model, name))
            for name in names
            if name in values
        }
    return Proposal(mechanism, own, {effect: _toml(model, mechanism, effect, own[effect]) for effect in own})


def _found(model: Model) -> tuple[dict[str, float], dict[str, float]]:
    """Return values and standard errors of all that a model moves, each record at what its residual is worth."""
    weighted, _ = by_own_residuals(model.problem, model.q, model.setting.windows)
    triangle = weighted.joint(model.q, model.setting.windows)
    names, slopes = weighted.coordinates.value_slopes(model.q)
    variance = np.einsum("ij,jk,ik->i", slopes, covariance(triangle), slopes)
    errors = dict(zip(names, np.sqrt(np.maximum(variance, 0.0)).tolist(), strict=True))
    return model.problem.coordinates.values(model.q), errors


def _names(model: Model) -> dict[str, list[str]]:
    """Return the dotted names of each effect's parameters in the model's problem, phases among them."""
    terms = model.library.term_of if model.library else {}
    found = {effect: [name for name, term in terms.items() if term == effect] for effect in model.terms}
    found |= {effect: list(model.parameters[effect]) for effect in model.disturbances}
    return found | {law: list(model.law_parameters) for law in model.laws}


def _renamed(model: Model, compact: dict[str, str]) -> dict[str, str]:
    """Return the names in the proposed file of parameters that stand elsewhere in the library's."""
    wide = model.library.term_of if model.library else {}
    pairs: dict[str, str] = {}
    for effect in model.terms:
        there, here = ([name for name, term in of.items() if term == effect] for of in (wide, compact))
        pairs |= dict(zip(there, here, strict=True))
    return pairs


def _unit(model: Model, name: str) -> str:
    known = model.problem.space.mechanism.parameters.get(name)
    own = {c.parameter.name: c.parameter for c in model.problem.coordinates.own}
    return (known or own[name]).declaration.unit


def _toml(model: Model, mechanism: Mechanism, effect: str, own: dict[str, OwnValue]) -> str:
    if effect in model.disturbances:
        one = next(one for one in model.setting.disturbances if one.name == effect)
        return one.toml({name: p.value for name, p in own.items()})
    return appendix_text(mechanism, own, model.setting.problem.space.mechanism)


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


@dataclass(frozen=True, kw_only=True)
class HeldOut:
    """A record that was not fitted: RMS of what is left of it over its noise, offset and drift removed.

    Attributes
    ----------
    record : str
    before, after : float
        As written, and with the effects.
    """

    record: str
    before: float
    after: float


def held_out(before: Model, after: Model, fit: Fit) -> tuple[HeldOut, ...]:
    """Return how well each record that was held out is predicted, with what the fit found on its first part."""
    campaign = campaign_as_fitted(fit.required_campaign, fit, disturbances=False)
    kept = tuple(replace(r, use="estimate") for r in campaign.records if r.use == "validate")
    if not kept:
        return ()
    mechanism = before.setting.problem.space.mechanism
    problem = make_problem(replace(campaign, mechanism=mechanism, records=kept), before.setting.problem.workers)
    setting = replace(before.setting, problem=problem, windows=problem.whole(), disturbances=())

    def norms(model: Model) -> list[float]:
        values = model.problem.coordinates.values(model.q)
        there = replace(model, setting=setting, disturbances=()).at(values)
        return there.problem.norms(there.q, setting.windows)

    counts = [t.samples * len(t.channels) for t in problem.targets]
    return tuple(
        HeldOut(record=t.name, before=one / n**0.5, after=other / n**0.5)
        for t, n, one, other in zip(problem.targets, counts, norms(before), norms(after), strict=True)
    )
