"""A finished fit as the model that a diagnosis begins from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from mechid.campaign import Campaign
from mechid.identification.diagnosis.candidate import Model, Setting
from mechid.identification.diagnosis.landscape import needed_effects
from mechid.identification.disturbance.possible import possible
from mechid.identification.identify import make_problem
from mechid.identification.refit.reopened import MOVED, as_fitted
from mechid.identification.result.terms_beside import TermsBeside
from mechid.plant.superset import rivals_of


def begun(campaign: Campaign, estimate: Mapping[str, Any], *, workers: int = 1) -> tuple[Model, Model]:
    """Return the mechanism as written at a fit's values, and the model with the effects that this fit needs already.

    Both are the same where the fit has no terms beside.
    """
    parameters = estimate["parameters"]
    campaign = as_fitted(campaign, estimate)
    values = {name: p["value"] for name, p in parameters.items()}
    moved = tuple(p.name for p in campaign.mechanism.free if parameters[p.name]["status"] in MOVED)
    here = {name: value for name, value in values.items() if name in campaign.mechanism.parameters}
    mechanism = campaign.mechanism.with_values(here).with_free(moved)
    problem = make_problem(replace(campaign, mechanism=mechanism), workers)
    q = problem.coordinates.point(values)
    disturbances = tuple(one for one in possible(problem, campaign, q) if one.parameters)  # lines are removed already
    setting = Setting(problem, problem.whole(), disturbances)
    plain = Model(setting, mechanism).at(values)
    found = estimate.get("beside")
    return plain, _with_terms(plain, TermsBeside.from_dict(found), values) if found else plain.fitted(plain)


def _with_terms(plain: Model, found: TermsBeside, values: Mapping[str, float]) -> Model:
    """Return the model with the terms of a fit that are needed, fitted without their small priors."""
    law = next((law for law in rivals_of(plain.base) if law.name in found.names), None)
    own = {name: p.value for name, p in found.parameters.items()}
    if law is not None:
        base = law.mechanism.with_values({n: v for n, v in own.items() if n in law.mechanism.parameters})
        model = replace(plain, base=base, laws=(law.name,)).at({**values, **own})
        return model.fitted(model)
    model = replace(plain, terms=found.names)
    library = model.library
    assert library is not None
    names: dict[str, list[str]] = {}
    for name, term in library.term_of.items():
        names.setdefault(term, []).append(name)
    there = {n: v for term, own in names.items() for n, v in _values(term, own, found).items()}
    model = model.at({**values, **there})
    kept = needed_effects(model, wanted_small=library.widths)
    return replace(model, terms=tuple(name for name in model.terms if name in kept)).fitted(model)


def _values(term: str, names: Sequence[str], found: TermsBeside) -> dict[str, float]:
    """Return the values that a fit gives the parameters of a term, by their names in the library: entries are moved."""
    there = sorted(name for name, p in found.parameters.items() if p.term == term)
    return {n: found.parameters[own].value for n, own in zip(sorted(names), there, strict=False)}
