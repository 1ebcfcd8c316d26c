"""Proposal of a diagnosis: the mechanism with the found effects, mains hum, and prediction of held-out records."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mechid.campaign.mechanism_text import appendix_text
from mechid.identification.diagnosis.candidate import CandidateModel
from mechid.identification.effects.disturbance import MAINS_PREFIX, Disturbance, lines_of, remove_disturbances
from mechid.identification.effects.mains import mains
from mechid.identification.effects.scores import scores, weight_by_residuals
from mechid.identification.effects.selection import is_significant
from mechid.identification.effects.settings import IN_DIAGNOSIS as RULES
from mechid.identification.identify import make_problem
from mechid.identification.result.finished_fit import campaign_as_fitted
from mechid.identification.result.fit import Fit
from mechid.identification.result.missing_effects import EffectValue, Missing
from mechid.identification.search.solve import covariance
from mechid.plant.mechanism import Mechanism
from mechid.plant.superset import superset_of


@dataclass(frozen=True, eq=False)
class Proposal:
    """A mechanism with the effects of a model, and the declaration of each effect.

    Attributes
    ----------
    mechanism : Mechanism
        Mechanism at the model's values, with free effects.
    own : mapping of str to mapping of str to EffectValue
        Parameters of each effect under their names in the file, by the effect's name.
    tomls : mapping of str to str
        Declaration of each effect alone, to append to the mechanism file or the campaign file.
    """

    mechanism: Mechanism
    own: dict[str, dict[str, EffectValue]]
    tomls: dict[str, str]


def build_proposal(model: CandidateModel) -> Proposal:
    """Build the proposal of a model."""
    values, errors = _values_and_errors(model)
    # A superset of the model's terms alone: in the file, list entries are numbered without the unused ones.
    superset = superset_of(model.base, only=model.terms, further=model.further) if model.terms else None
    mechanism = superset.with_free_terms(model.terms) if superset else model.base
    renamed = _map_names(model, superset.term_of if superset else {})
    here = {renamed.get(name, name): value for name, value in values.items()}
    mechanism = mechanism.with_values({n: v for n, v in here.items() if n in mechanism.parameters})
    own: dict[str, dict[str, EffectValue]] = {}
    for effect, names in _names_by_effect(model).items():
        own[effect] = {
            renamed.get(name, name): EffectValue(value=values[name], std_error=errors[name], unit=_unit(model, name))
            for name in names
            if name in values
        }
    return Proposal(mechanism, own, {effect: _toml(model, mechanism, effect, own[effect]) for effect in own})


def _values_and_errors(model: CandidateModel) -> tuple[dict[str, float], dict[str, float]]:
    """Return values and standard errors of a model's free parameters, with weights by each record's own residual."""
    weighted, _ = weight_by_residuals(model.problem, model.q, model.setting.windows)
    triangle = weighted.joint(model.q, model.setting.windows)
    names, slopes = weighted.coordinates.value_slopes(model.q)
    variance = np.einsum("ij,jk,ik->i", slopes, covariance(triangle), slopes)
    # Rounding may leave a small negative variance.
    errors = dict(zip(names, np.sqrt(np.maximum(variance, 0.0)).tolist(), strict=True))
    return model.problem.coordinates.values(model.q), errors


def _names_by_effect(model: CandidateModel) -> dict[str, list[str]]:
    """Return the dotted names of each effect's parameters in the model's problem, including phases."""
    terms = model.library.term_of if model.library else {}
    found = {effect: [name for name, term in terms.items() if term == effect] for effect in model.terms}
    found |= {effect: list(model.parameters[effect]) for effect in model.disturbances}
    return found | {law: list(model.law_parameters) for law in model.laws}


def _map_names(model: CandidateModel, compact: dict[str, str]) -> dict[str, str]:
    """Map the parameters' names in the library's mechanism to their names in the proposed file."""
    wide = model.library.term_of if model.library else {}
    pairs: dict[str, str] = {}
    for effect in model.terms:
        there, here = ([name for name, term in of.items() if term == effect] for of in (wide, compact))
        pairs |= dict(zip(there, here, strict=True))
    return pairs


def _unit(model: CandidateModel, name: str) -> str:
    known = model.problem.space.mechanism.parameters.get(name)
    own = {c.parameter.name: c.parameter for c in model.problem.coordinates.own}
    return (known or own[name]).declaration.unit


def _toml(model: CandidateModel, mechanism: Mechanism, effect: str, own: dict[str, EffectValue]) -> str:
    if effect in model.disturbances:
        one = next(one for one in model.setting.disturbances if one.name == effect)
        return one.toml({name: p.value for name, p in own.items()})
    return appendix_text(mechanism, own, model.setting.problem.space.mechanism)


def confirmed_hum(model: CandidateModel, fit: Fit) -> list[Missing]:
    """Return the mains hum that a fit reports and the records also show with the model's effects.

    Steps have lines like those of the mains, so a missing effect may look like hum.
    """
    named = [one for one in fit.missing if one.name.startswith(MAINS_PREFIX)]
    if not named:
        return []
    lines = tuple(lines_of(model.problem))
    removed = Disturbance("", "", lines_hz={t.name: lines for t in model.problem.targets})
    bare, q = remove_disturbances(model.problem, model.q, [removed])
    seen = mains(bare, q)
    if seen is None:
        return []
    score = scores(bare, q, model.setting.windows, [seen])[seen.name]
    return [one for one in named if one.name == seen.name and is_significant(score, RULES)]


@dataclass(frozen=True, kw_only=True)
class HeldOut:
    """Residual-to-noise ratio of a record that was not fitted, offset and drift removed.

    Attributes
    ----------
    record : str
    before, after : float
        Ratio of the mechanism as written, and with the effects.
    """

    record: str
    before: float
    after: float


def predict_held_out(before: CandidateModel, after: CandidateModel, fit: Fit) -> tuple[HeldOut, ...]:
    """Return the prediction of each held-out record, with the parameters that the fit found on its first part."""
    campaign = campaign_as_fitted(fit.required_campaign, fit, disturbances=False)
    kept = tuple(replace(r, use="estimate") for r in campaign.records if r.use == "validate")
    if not kept:
        return ()
    mechanism = before.setting.problem.space.mechanism
    problem = make_problem(replace(campaign, mechanism=mechanism, records=kept), before.setting.problem.workers)
    setting = replace(before.setting, problem=problem, windows=problem.whole_windows(), disturbances=())

    def norms(model: CandidateModel) -> list[float]:
        values = model.problem.coordinates.values(model.q)
        there = replace(model, setting=setting, disturbances=()).at(values)
        return there.problem.norms(there.q, setting.windows)

    counts = [t.samples * len(t.channels) for t in problem.targets]
    return tuple(
        HeldOut(record=t.name, before=one / n**0.5, after=other / n**0.5)
        for t, n, one, other in zip(problem.targets, counts, norms(before), norms(after), strict=True)
    )
