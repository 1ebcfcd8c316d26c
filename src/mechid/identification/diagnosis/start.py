"""Initial models of a diagnosis, built from a finished fit, and suggestions by the derivatives alone."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace

from scipy.special import chdtrc

from mechid.campaign import Campaign
from mechid.campaign.campaign import key_in_record
from mechid.campaign.diagnose_options import CONSIDER, DIAGNOSE
from mechid.errors import InputFileError, did_you_mean
from mechid.identification.computation.parallel import one_core_algebra
from mechid.identification.diagnosis.candidate import CandidateModel, Setting
from mechid.identification.effects.campaign_disturbances import possible_disturbances
from mechid.identification.effects.effect import add_terms
from mechid.identification.effects.selection import likely_effects
from mechid.identification.effects.settings import IN_DIAGNOSIS as RULES
from mechid.identification.identify import make_problem
from mechid.identification.result.finished_fit import campaign_as_fitted
from mechid.identification.result.fit import ESTIMATED_STATUSES, Fit
from mechid.identification.result.grade import Grade
from mechid.identification.result.missing_effects import Missing, SuggestedEffect
from mechid.identification.result.record_result import masks_of
from mechid.identification.search.masks import apply_masks
from mechid.plant.law import Law
from mechid.plant.mechanism import Mechanism
from mechid.plant.superset import extension_named, rivals_of, with_tables, words_of


def initial_models(fit: Fit, *, workers: int = 1) -> tuple[CandidateModel, CandidateModel]:
    """Return the mechanism as written at the values of a fit, and the model with the effects that the fit needs.

    Both are the same where the fit has neither added terms nor disturbances. The fit has to hold its campaign.
    """
    plain = _plain_model(fit, workers)
    return plain, _add_effects_of_fit(plain, fit)


def model_of_fit(fit: Fit, *, workers: int = 1) -> CandidateModel:
    """Return the mechanism as written with the disturbances of a fit, at its values."""
    plain = _plain_model(fit, workers)
    return replace(plain, disturbances=_disturbances(plain, fit)).at(fit.values)


def _plain_model(fit: Fit, workers: int) -> CandidateModel:
    """Return the mechanism as written at the values of a fit."""
    campaign = campaign_as_fitted(fit.required_campaign, fit, disturbances=False)
    # A fit of grade C may have held a parameter only because of its wrong branch, so all are free again.
    free, is_on_a_branch = campaign.mechanism.free, fit.grade is Grade.C
    moved = tuple(p.name for p in free if is_on_a_branch or fit.parameters[p.name].status in ESTIMATED_STATUSES)
    here = {name: value for name, value in fit.values.items() if name in campaign.mechanism.parameters}
    wide = with_tables(campaign.mechanism, _tables_of_records(fit, campaign.mechanism))
    mechanism = wide.with_values(here).with_free(moved)
    problem = apply_masks(make_problem(replace(campaign, mechanism=mechanism), workers), masks_of(fit.records))
    disturbances = possible_disturbances(problem, campaign, problem.coordinates.point(fit.values))
    # Mains lines have no parameters to fit; they are removed from the records already.
    parametric = tuple(one for one in disturbances if one.parameters)
    known = {*words_of(mechanism), *(one.name for one in parametric), *(one.name for one in fit.added_terms)}
    setting = Setting(problem, problem.whole_windows(), parametric, _candidate_names(campaign, known))
    return CandidateModel(setting, mechanism).at(fit.values)


def _tables_of_records(fit: Fit, written: Mechanism) -> frozenset[str]:
    """Return the tables that a mechanism lacks although a fit found per-record values of theirs, such as gains."""
    own = {key_in_record(n) for one in fit.missing for n in one.parameters if n.startswith("record.")}
    replaced = {name for key, name in fit.mechanism.plant.of_record.items() if key in own}
    return frozenset(name.rpartition(".")[0] for name in replaced - written.parameters.keys())


def _disturbances(plain: CandidateModel, fit: Fit) -> tuple[str, ...]:
    """Return the names of the fit's disturbances that are candidates of the diagnosis."""
    known = {one.name for one in plain.setting.disturbances} & plain.setting.considered
    return tuple(one.name for one in fit.missing if one.name in known)


def _add_effects_of_fit(plain: CandidateModel, fit: Fit) -> CandidateModel:
    """Return the model with the fit's needed disturbances and terms, fitted without small priors."""
    model = replace(plain, disturbances=_disturbances(plain, fit))
    found = {one.name: one for one in fit.added_terms}
    own = {name: p.value for one in found.values() for name, p in one.parameters.items()}
    law = next((law for law in rivals_of(plain.base) if law.entry_name in found and _has_orders(fit, law)), None)
    if law is not None and law.name in plain.setting.considered:
        base = law.mechanism.with_values({n: v for n, v in own.items() if n in law.mechanism.parameters})
        model = replace(model, base=base, laws=(law.name,))
    terms = {name: one for name, one in found.items() if law is None or name != law.entry_name}
    if terms:
        return _add_terms_of_fit(model, terms, fit.values).regrow()
    model = model.at(fit.values)
    return model.fit(model).regrow()


def _has_orders(fit: Fit, law: Law) -> bool:
    """Return whether a fit's mechanism has a law with the law's own orders, such as that of a low-pass."""
    fitted, alternative = fit.mechanism.plant.layout, law.mechanism.plant.layout
    if fitted is None or alternative is None:
        return False
    tables = {name.partition(".")[0] for name in law.own}
    return all(fitted.orders.get(table) == alternative.orders.get(table) for table in tables)


def _add_terms_of_fit(
    model: CandidateModel, found: Mapping[str, Missing], values: Mapping[str, float]
) -> CandidateModel:
    """Add the terms of a fit to a model, keep the needed terms and disturbances, and fit."""
    listed = {term.name for term in model.library.terms} if model.library else set[str]()
    others = (extension_named(model.base, name) for name in found if name not in listed)
    further = (*model.further, *(one for one in others if one))
    model = replace(model, terms=tuple(found), further=further)
    library = model.library
    assert library is not None
    names = add_terms(library, found.keys()).names_by_term
    there = {n: v for term, one in found.items() for n, v in _values(names[term], one).items()}
    model = model.at({**values, **there})
    return model.keep_effects(model.needed_effects(library.widths) & model.setting.considered)


def _values(names: Sequence[str], added: Missing) -> dict[str, float]:
    """Return the values of an added term by its names in the library, in which list entries are numbered otherwise."""
    return {
        n: p.value for n, p in zip(sorted(names), map(added.parameters.get, sorted(added.parameters)), strict=True) if p
    }


def _candidate_names(campaign: Campaign, known: Collection[str]) -> frozenset[str]:
    """Return the names of the candidate effects.

    A name without a suffix, such as ``"stepper.detent"``, stands for all effects of that kind.

    Raises
    ------
    InputFileError
        If the campaign file names an unknown effect.
    """
    chosen: set[str] = set()
    for index, name in enumerate(campaign.considered):
        of_kind = {one for one in known if name in (one, one.partition(":")[0])}
        if not of_kind:
            near = did_you_mean(name, known) or f"; there are {', '.join(sorted(known))}"
            place = f"{campaign.path.name}: {DIAGNOSE}.{CONSIDER}[{index}], or --{CONSIDER}"
            raise InputFileError(f'{place}: found "{name}", which is not an effect of this campaign{near}')
        chosen |= of_kind
    return frozenset(chosen if campaign.considered else known)


def add_suggestions(fit: Fit, workers: int = 1, say: Callable[[str], None] = lambda line: None) -> Fit:
    """Add suggestions to a fit of grade B or C: single effects that its residual supports, none of them fitted.

    A fit with added terms gets none, since its search has tested such effects.
    """
    if fit.grade not in (Grade.B, Grade.C) or fit.as_written:
        return fit
    say("asking the residual what the model is missing ...")
    with one_core_algebra():
        model = model_of_fit(fit, workers=workers)
        return replace(fit, suggested=_suggestions(model))


def _suggestions(model: CandidateModel) -> tuple[SuggestedEffect, ...]:
    scores, words = model.scores(), model.words
    return tuple(
        SuggestedEffect(
            name=name,
            words=words[name],
            chi_square=one.chi_square,
            dof=one.dof,
            share=one.share,
            p_value=float(chdtrc(one.dof, one.chi_square)),
        )
        for name, one in ((name, scores[name]) for name in likely_effects(model, scores)[: RULES.suggested])
    )
