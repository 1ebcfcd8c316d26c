"""The mechanism that a diagnosis proposes: as written, with the effects that its records ask for, laid out alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechid.campaign.mechanism_text import appendix_text
from mechid.identification.diagnosis.candidate import Model
from mechid.identification.effects.scores import by_own_residuals
from mechid.identification.result.missing import OwnValue
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
    mechanism = superset.freeing(model.terms) if superset else model.base
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
