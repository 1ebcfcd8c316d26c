"""The mechanism as written, of a fit that has terms beside it: its values stay, the terms are named and left away."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace

import numpy as np

from mechid.campaign import Campaign
from mechid.identification.effects.effect import Beside
from mechid.identification.result.estimated_mechanism import PLANT
from mechid.identification.result.fit import Fit, RecordFit
from mechid.identification.result.grade import Cause, Reason, grade_of
from mechid.identification.result.record_fit import record_fit
from mechid.identification.result.search_state import SearchState
from mechid.identification.result.terms_beside import TermBeside, TermsBeside
from mechid.plant.superset import words_of

NAMED = 3
"""Terms that a sentence names, the clearest; a choice, not measured."""
NONE_CLEAR = "none is clear by itself"


def as_written(fit: Fit, campaign: Campaign, state: SearchState, beside: Beside) -> Fit:
    """Return a fit of a mechanism with terms beside as one of the mechanism in the campaign's file.

    The values and their errors are those found together with the terms: what these may take of a parameter is in its
    error. Records are predicted by the mechanism as written, with the disturbances of the records.

    Parameters
    ----------
    fit : Fit
        Graded, of the mechanism with the terms.
    campaign : Campaign
        Its mechanism as written, its records with what they have of their own.
    state : SearchState
        At the end of the search.
    beside : Beside
        The terms.
    """
    mechanism = campaign.mechanism.with_values({n: fit.mechanism.value(n) for n in _free(campaign)})
    values = {name: p.value for name, p in fit.parameters.items()}
    problem = Beside(mechanism).problem(state.problem)
    written = {
        n: p for n, p in fit.parameters.items() if n in mechanism.parameters or n not in beside.mechanism.parameters
    }
    kept = [i for i, name in enumerate(fit.correlation_names) if name in written]
    q = problem.coordinates.point(values)
    found = replace(
        fit,
        mechanism=mechanism,
        parameters=written,
        correlation_names=tuple(fit.correlation_names[i] for i in kept),
        correlation=fit.correlation[np.ix_(kept, kept)],
        covariance=fit.covariance[np.ix_(kept, kept)],
        records={
            r.name: replace(record_fit(r, problem, q, state.windows), taken=fit.records[r.name].taken)
            for r in campaign.records
            if r.name in fit.records
        },
        beside=_terms(fit, beside, words_of(mechanism)),
        provenance={**fit.provenance, PLANT: mechanism.plant.digest},
    )
    estimated = [target.name for target in problem.targets]
    reasons = (*fit.reasons, incomplete(found, fit, estimated, str(campaign.path)))
    return replace(found, reasons=reasons, grade=grade_of(reasons))


def _free(campaign: Campaign) -> list[str]:
    return [p.name for p in campaign.mechanism.free]


def _terms(fit: Fit, beside: Beside, words: Mapping[str, str]) -> TermsBeside:
    meanings = {name: beside.mechanism.parameters[name].declaration.meaning for name in beside.new}
    own = {
        name: TermBeside(
            value=p.value,
            std_error=p.std_error,
            unit=p.unit,
            width=beside.widths.get(name),
            term=beside.new[name],
            meaning=meanings[name],
        )
        for name, p in fit.parameters.items()
        if name in beside.new
    }
    return TermsBeside(names=beside.terms, words={name: words[name] for name in beside.terms}, parameters=own)


def incomplete(fit: Fit, with_terms: Fit, estimated: Collection[str], campaign: str) -> Reason:
    """Return that the mechanism file is not complete: what stands beside it, and what is left without that.

    Parameters
    ----------
    fit : Fit
        Its records as the mechanism as written predicts them.
    with_terms : Fit
        Its records as they are predicted with the terms.
    estimated : collection of str
        Records that the fit rests on, of which the one with most residual beside its noise is named.
    campaign : str
        Its file, as it is typed.
    """
    words, clear = (fit.beside.words, fit.beside.clear[:NAMED]) if fit.beside else ({}, ())
    worst = max(estimated, key=lambda name: _over_noise(fit.records[name]))
    record, with_them = fit.records[worst], _over_noise(with_terms.records[worst])
    which = f"the clearest: {', '.join(f'{words[name]} ({name})' for name in clear)}" if clear else NONE_CLEAR
    share = f" (and follows {record.followed_percent:.3g} % of it)" if record.followed_percent < 100.0 else ""
    text = (
        f"The mechanism file lacks something. The records ask for further terms that its blocks may have; {which}. "
        "Values and errors were found together with these terms. Without them, at these values, the model leaves "
        f"{_over_noise(record):.3g} times the noise of record {worst}{share}; with them {with_them:.3g} times."
    )
    again = f"mechid identify {campaign} --out DIR, with {', '.join(clear) or 'what it lacks'} in the mechanism file"
    return Reason(cause=Cause.INCOMPLETE, record=worst, text=text, next_command=again)


def _over_noise(record: RecordFit) -> float:
    return record.residual_rms / (record.noise_known or record.noise_sigma)
