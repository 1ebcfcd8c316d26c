"""Terms and laws that a fit added to the mechanism: gain by each, and comparison with the mechanism as written."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from scipy.special import chdtrc

from mechid.campaign import Campaign, CampaignRecord
from mechid.campaign.mechanism_text import appendix_text
from mechid.identification.effects.disturbance import missing_tables
from mechid.identification.effects.effect import AddedTerms, lay_out
from mechid.identification.effects.pruning import linearise
from mechid.identification.effects.scores import weight_by_residuals
from mechid.identification.grading import DIAGNOSE
from mechid.identification.output_error.problem import Problem
from mechid.identification.result.fit import Fit
from mechid.identification.result.grade import Cause, FitOutcome, Reason
from mechid.identification.result.missing_effects import AsWritten, EffectValue, Missing, missing_warning
from mechid.identification.result.record_fit import record_fit
from mechid.identification.result.record_result import RecordFit
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.solve import solve
from mechid.identification.stages.settings import STAGES
from mechid.plant.mechanism import Mechanism
from mechid.plant.superset import extension_named, rivals_of, superset_of, with_tables, words_of


def add_missing_entries(fit: Fit, campaign: Campaign, state: SearchState) -> Fit:
    """Add an entry of `missing` and a warning for each added term, and the prediction of the mechanism as written.

    Parameters
    ----------
    fit : Fit
        Fit of the mechanism with the terms.
    campaign : Campaign
        Campaign with the mechanism as written, and the records as the fit read them.
    state : SearchState
        State at the end of the search.
    """
    # A table alone, for gains of records, is no effect.
    if state.added is None or not state.added.names:
        return fit
    terms = missing_terms(fit, campaign.mechanism, state)
    return replace(
        fit,
        missing=(*terms, *fit.missing),
        as_written=predict_as_written(fit, campaign, state),
        warnings=(*map(missing_warning, terms), *fit.warnings),
    )


def missing_terms(fit: Fit, written: Mechanism, state: SearchState) -> tuple[Missing, ...]:
    """Return an entry of ``missing`` for each term or law that a search added to the mechanism.

    Its chi-square is the rise of the cost without it, at each record's residual level and effective sample count. For
    a term it follows from the derivatives at the estimate, with all other parameters free to compensate; for a law,
    from a fit of the mechanism as written.

    Parameters
    ----------
    fit : Fit
        Fit whose mechanism has the terms, at the estimate.
    written : Mechanism
        Mechanism as the user wrote it.
    state : SearchState
        State at the end of the search.
    """
    added = state.added
    if added is None or not added.new:
        return ()
    by_name = {name: added.parameters_of(name) for name in added.names}
    falls, total = _cost_falls(state, written, added)
    words = _words(written, added)
    entry_names = {law.name: law.entry_name for law in rivals_of(written)}
    if not all(map(math.isfinite, falls.values())):
        # A point that cannot be simulated explains nothing.
        return ()
    return tuple(
        Missing(
            name=entry_names.get(name, name),
            words=words.get(name, name),
            parameters={p: _own_value(fit, p) for p in by_name[name] if p in fit.parameters},
            chi_square=fall,
            dof=len(by_name[name]),
            share=min(fall / total, 1.0),
            p_value=float(chdtrc(len(by_name[name]), fall)),
            records=tuple(state.windows),
            toml=appendix_text(fit.mechanism, by_name[name], written),
            block=by_name[name][0].rpartition(".")[0].rstrip(".0123456789"),
            aliases=added.aliases.get(name, ()),
        )
        for name, fall in sorted(falls.items(), key=lambda item: -item[1])
    )


def _words(written: Mechanism, added: AddedTerms) -> dict[str, str]:
    """Return the description of each added term or law by its name, including terms that no block lists."""
    words = words_of(written)
    others = {name: extension_named(written, name) for name in added.terms if name not in words}
    further = [one for one in others.values() if one]
    superset = superset_of(written, only=others, further=further) if further else None
    return words | {term.name: term.words for term in (superset.terms if superset else ())}


def _own_value(fit: Fit, name: str) -> EffectValue:
    p = fit.parameters[name]
    return EffectValue(value=p.value, std_error=p.std_error, unit=p.unit)


def _cost_falls(state: SearchState, written: Mechanism, added: AddedTerms) -> tuple[dict[str, float], float]:
    """Return the fall of the cost by each added term or law, and by all of them."""
    by_term = added.names_by_term
    found, total = dict[str, float](), 0.0
    if by_term:
        at = linearise(state.problem, state.q, state.windows, by_term)
        rises = at.rises() if at else dict.fromkeys((*by_term, ""), math.nan)
        found = {name: max(rises.get(name, 0.0), 0.0) for name in by_term}
        # The rise without all terms: effects overlap, so single rises do not add up to it.
        total = max(rises[""], 0.0)
    if added.law:
        found[added.law] = _fall_by_law(state, written, added)
        total += found[added.law]
    return found, max(total, 1e-300)


def _fall_by_law(state: SearchState, written: Mechanism, added: AddedTerms) -> float:
    """Return the fall of the cost by a law in place of the user's, compared with a refit of the user's law."""
    weighted, _ = weight_by_residuals(state.problem, state.q, state.windows)
    cost = weighted.total_norm(state.q, state.windows) ** 2
    moved = {p.name for p in weighted.space.mechanism.free}
    without_law = lay_out(AddedTerms(written), added.terms, _tables(written, state)).mechanism
    free = tuple(p.name for p in without_law.free if p.name in moved)
    plain = AddedTerms(without_law.with_free(free)).problem(weighted)
    q = plain.coordinates.clip(plain.coordinates.point(weighted.coordinates.values(state.q)))
    # A user who interrupts does not wait for another fit.
    if state.outcome is not FitOutcome.INTERRUPTED:
        q = solve(plain, q, state.windows, steps=STAGES.joint_steps, tolerance=STAGES.rough_tolerance).q
    return max(plain.total_norm(q, state.windows) ** 2 - cost, 0.0)


def _tables(written: Mechanism, state: SearchState) -> frozenset[str]:
    """Return the tables that a mechanism lacks for the disturbances found in the records."""
    return missing_tables(written, [found.disturbance for found in state.found])


def predict_as_written(fit: Fit, campaign: Campaign, state: SearchState) -> AsWritten:
    """Predict the records by the mechanism as written, at the values of a fit with added terms.

    Added terms are at their null values, and an alternative law is replaced by the user's.

    Parameters
    ----------
    fit : Fit
        Fit with the added terms.
    campaign : Campaign
        Campaign with the mechanism as written, and the records as the fit read them.
    state : SearchState
        State at the end of the search.
    """
    own = {p.name: fit.mechanism.value(p.name) for p in campaign.mechanism.free}
    written = with_tables(campaign.mechanism, _tables(campaign.mechanism, state))
    problem = AddedTerms(written.with_values(own).with_free(())).problem(state.problem)
    values = {name: p.value for name, p in fit.parameters.items()}
    records = [r for r in campaign.records if r.name in fit.records]
    found = {r.name: _predict_record(r, fit.records[r.name], problem, values, state) for r in records}
    fitted = [c for name in state.windows for c in found[name].channels.values() if c.use == "estimate"]
    ratios = {name: r.residual_over_noise for name, r in found.items()}
    return AsWritten(follows=all(c.is_followed for c in fitted), residual_over_noise=ratios)


def _predict_record(
    record: CampaignRecord, found: RecordFit, problem: Problem, values: Mapping[str, float], state: SearchState
) -> RecordFit:
    """Return the fit of a problem to a record, over the samples on which the fit judged it."""
    if not found.nuisance:
        return record_fit(record, problem, problem.coordinates.point(values), state.windows)
    window = (found.nuisance.samples, found.nuisance.samples + found.samples)
    settled = record.with_known_values(found.nuisance.values)
    return record_fit(settled, problem, problem.coordinates.point(values), {record.name: window})


def incomplete_reason(fit: Fit, campaign: Campaign, state: SearchState) -> Reason | None:
    """Return the reason that the mechanism file is incomplete, with the added terms; None if nothing was added.

    Parameters
    ----------
    fit : Fit
        Fit with its entries `missing` and `as_written`.
    campaign : Campaign
    state : SearchState
    """
    if state.added is None or fit.as_written is None:
        return None
    terms = fit.added_terms
    if not state.added.names:
        return None
    names = [f"{one.words} ({one.name})" for one in terms[: STAGES.most_named]] or list(state.added.names)
    more = f" and {len(terms) - STAGES.most_named} more" if len(terms) > STAGES.most_named else ""
    effects, them = ("effects", "them") if len(state.added.names) > 1 else ("an effect", "it")
    ratios = fit.as_written.residual_over_noise
    worst = max(state.windows, key=lambda name: ratios[name])
    left, alone = fit.records[worst].residual_over_noise, ratios[worst]
    text = (
        f"The mechanism file lacks {effects} that the records need; added: {', '.join(names)}{more}. Without {them}, "
        f"at the same values, the residual of record {worst} is {alone:.3g} times its noise; with {them}, "
        f"{left:.3g} times."
    )
    written = ", ".join(one.name for one in terms[: STAGES.most_named]) + more
    again = f"mechid identify {campaign.path} --out DIR, with {written} in the mechanism file; or {DIAGNOSE}"
    return Reason(cause=Cause.INCOMPLETE, record=worst, text=text, next_command=again)
