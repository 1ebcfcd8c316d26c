"""A finished fit as the model that a diagnosis begins from, with the effects that are looked for."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any

from mechid.campaign import Campaign
from mechid.campaign.diagnose_options import CONSIDER, DIAGNOSE
from mechid.errors import InputFileError, did_you_mean
from mechid.identification.diagnosis.candidate import Model, Setting
from mechid.identification.effects.campaign_disturbances import possible
from mechid.identification.identify import make_problem
from mechid.identification.refit.reopened import MOVED, as_recorded
from mechid.identification.result.grade import Grade
from mechid.identification.result.terms_beside import TermsBeside
from mechid.plant.superset import rivals_of, words_of


def begun(campaign: Campaign, estimate: Mapping[str, Any], *, workers: int = 1) -> tuple[Model, Model]:
    """Return the mechanism as written at a fit's values, and the model with the effects that this fit needs already.

    Both are the same where the fit has no terms beside and no disturbances.
    """
    plain = _plain(campaign, estimate, workers)
    return plain, _with_found(plain, estimate, _values_of(estimate))


def as_written(campaign: Campaign, estimate: Mapping[str, Any], *, workers: int = 1) -> Model:
    """Return the mechanism as written and the disturbances of a fit, at its values."""
    plain = _plain(campaign, estimate, workers)
    return replace(plain, disturbances=_disturbances(plain, estimate)).at(_values_of(estimate))


def _values_of(estimate: Mapping[str, Any]) -> dict[str, float]:
    return {name: p["value"] for name, p in estimate["parameters"].items()}


def _plain(campaign: Campaign, estimate: Mapping[str, Any], workers: int) -> Model:
    """Return the mechanism as written at a fit's values."""
    parameters = estimate["parameters"]
    campaign = as_recorded(campaign, estimate)
    values = _values_of(estimate)
    on_a_branch = estimate["grade"] == Grade.C  # where it holds a parameter, it may do so for that branch alone
    free = campaign.mechanism.free
    moved = tuple(p.name for p in free if on_a_branch or parameters[p.name]["status"] in MOVED)
    here = {name: value for name, value in values.items() if name in campaign.mechanism.parameters}
    mechanism = campaign.mechanism.with_values(here).with_free(moved)
    problem = make_problem(replace(campaign, mechanism=mechanism), workers)
    disturbances = possible(problem, campaign, problem.coordinates.point(values))
    parametric = tuple(one for one in disturbances if one.parameters)  # lines are removed already
    known = {*words_of(mechanism), *(one.name for one in parametric)}
    setting = Setting(problem, problem.whole(), parametric, _considered(campaign, known))
    return Model(setting, mechanism).at(values)


def _disturbances(plain: Model, estimate: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the names of the disturbances of a fit that are looked for."""
    known = {one.name for one in plain.setting.disturbances} & plain.setting.considered
    return tuple(one["name"] for one in estimate["missing"] if one["name"] in known)


def _with_found(plain: Model, estimate: Mapping[str, Any], values: Mapping[str, float]) -> Model:
    """Return the model with the disturbances and terms of a fit that are needed, fitted without small priors."""
    model = replace(plain, disturbances=_disturbances(plain, estimate))
    found = TermsBeside.from_dict(estimate["beside"]) if estimate.get("beside") else None
    own = {name: p.value for name, p in found.parameters.items()} if found else {}
    law = next((law for law in rivals_of(plain.base) if found and law.name in found.names), None)
    if law is not None and law.name in plain.setting.considered:
        base = law.mechanism.with_values({n: v for n, v in own.items() if n in law.mechanism.parameters})
        model = replace(model, base=base, laws=(law.name,)).at({**values, **own})
        return model.fitted(model).regrown()
    if found is not None and law is None:
        return _with_terms(model, found, values).regrown()
    model = model.at(values)
    return model.fitted(model).regrown()


def _with_terms(model: Model, found: TermsBeside, values: Mapping[str, float]) -> Model:
    """Return the model with the terms of a fit, and of these and the disturbances what is needed, fitted."""
    model = replace(model, terms=found.names)
    library = model.library
    assert library is not None
    names: dict[str, list[str]] = {}
    for name, term in library.term_of.items():
        names.setdefault(term, []).append(name)
    there = {n: v for term, own in names.items() for n, v in _values(term, own, found).items()}
    model = model.at({**values, **there})
    return model.keeping(model.needed_effects(library.widths) & model.setting.considered)


def _values(term: str, names: Sequence[str], found: TermsBeside) -> dict[str, float]:
    """Return the values that a fit gives the parameters of a term, by their names in the library: entries are moved."""
    there = sorted(name for name, p in found.parameters.items() if p.term == term)
    return {n: found.parameters[own].value for n, own in zip(sorted(names), there, strict=False)}


def _considered(campaign: Campaign, known: Collection[str]) -> frozenset[str]:
    """Return the names of the effects that are looked for.

    A name without what tells its kind apart, as ``"stepper.detent"``, stands for all of that kind.

    Raises
    ------
    InputFileError
        The campaign file names one that is not known.
    """
    chosen: set[str] = set()
    for index, name in enumerate(campaign.considered):
        of_kind = {one for one in known if name in (one, one.partition(":")[0])}
        if not of_kind:
            near = did_you_mean(name, known) or f"; there are {', '.join(sorted(known))}"
            place = f"{campaign.path.name}: {DIAGNOSE}.{CONSIDER}[{index}], or --{CONSIDER}"
            raise InputFileError(f'{place}: found "{name}", which no effect is called here{near}')
        chosen |= of_kind
    return frozenset(chosen if campaign.considered else known)
