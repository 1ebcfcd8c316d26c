"""Grading of a finished fit: reasons from its records, parameters, consistency and outcome."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import islice

from mechid.identification.result.fit import Fit
from mechid.identification.result.grade import Cause, Consistency, FitOutcome, Reason, Scatter, grade_of
from mechid.identification.result.parameter_estimate import ParameterEstimate
from mechid.identification.result.record_result import ChannelFit, RecordFit
from mechid.identification.result.settings import GRADE
from mechid.identification.search.settings import SEARCH
from mechid.identification.uncertainty.settings import NOISE
from mechid.plant.tables import table_of

DIAGNOSE = "mechid diagnose FIT --out DIR, FIT being the result folder"
"""Next command where the model lacks an effect; `mechid check` examines declarations only and does not use a fit."""
NEGATIVE_LOSS: Mapping[str, str] = {
    "gear": "backlash or hysteresis of the gear, or channels that are not sampled at the same time",
    "friction": "another law of friction, or torque that the input channel does not contain",
    "output_friction": "another law of friction, or cables that push the load",
}
"""Effects that look like a negative damping or friction, by table of the mechanism file."""
PART_WORDS = {"phase": "the phases of a step", "record": "records", "time": "stretches of 0.1 s"}


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """Evidence for a grade in addition to the fit itself.

    Attributes
    ----------
    campaign : str
        Campaign file or folder, as typed.
    used : collection of str
        Fitted records.
    used_to_s : mapping of record to float
        Record time up to which a record was used that should have been used whole.
    predicted_reduction : float
        Fall of the cost that the derivatives still predict, in sigmas squared.
    cost : float
    lost : bool
        Whether the simulation fails at the estimate.
    contradicted : mapping of dotted name to str
        Values of the mechanism file that the records contradict, with a sentence each.
    circumstances : callable
        Function that describes the events in a record at an instant, as one or more clauses.
    seed : int
        Seed of the search.
    incomplete : Reason or None
        Reason that the fit added terms to the mechanism file; None where it added none.
    """

    campaign: str
    used: Collection[str]
    used_to_s: Mapping[str, float]
    predicted_reduction: float
    cost: float
    lost: bool
    contradicted: Mapping[str, str]
    circumstances: Callable[[str, float], str]
    seed: int = 0
    incomplete: Reason | None = None


def grade_fit(fit: Fit, evidence: Evidence) -> Fit:
    """Set the grade of a fit and its reasons."""
    reasons = tuple(_reasons(fit, evidence))
    return replace(fit, grade=grade_of(reasons), reasons=reasons)


def _reasons(fit: Fit, evidence: Evidence) -> Iterator[Reason]:
    again = f"mechid identify {evidence.campaign} --out DIR"
    if fit.outcome is FitOutcome.INTERRUPTED:
        yield Reason(cause=Cause.INTERRUPTED, text=fit.outcome.value, next_command=f"{again} --resume")
        return
    if fit.outcome is FitOutcome.FAILED or evidence.lost:
        text = FitOutcome.FAILED.value if fit.outcome is FitOutcome.FAILED else "The simulation fails at the estimate."
        yield Reason(cause=Cause.NOT_SIMULATED, text=text, next_command=f"mechid check {evidence.campaign}")
        return
    yield from (_value_reason(name, text, again) for name, text in evidence.contradicted.items())
    # Wrong values and bounds come first: mostly they are the cause of records that are not followed.
    yield from (_bound_reason(p, again) for p in fit.parameters.values() if p.contradicted)
    yield from (_physical_limit_reason(p) for p in fit.parameters.values() if p.at_physical_limit)
    for record in fit.records.values():
        yield from _record_reasons(record, evidence)
    yield from _excess_reasons(fit, evidence)
    yield from _held_out_reasons(fit, evidence)
    yield from _search_reasons(fit, evidence)
    if evidence.incomplete:
        yield evidence.incomplete
    found = fit.consistency
    if found and not found.agrees:
        yield _disagreement_reason(fit, found, evidence)
    elif not found or (found.phase is None and found.record is None):
        yield from islice(_unexplained_reasons(fit, evidence), 1)


def _record_reasons(record: RecordFit, evidence: Evidence) -> Iterator[Reason]:
    """Yield the reasons why a fitted record is not followed in full; the first loss of a record is enough."""
    if record.reading.left_out:
        text = f"Record {record.name} was left out of the fit: as declared, it contradicts the other records."
        check = f"mechid check {evidence.campaign}"
        yield Reason(cause=Cause.LEFT_OUT, record=record.name, text=text, next_command=check)
        return
    if record.name not in evidence.used:
        return
    if record.masked:
        at_s = record.masked[0].from_s
        text = f"Record {record.name}: {record.describe_masked()}."
        yield Reason(cause=Cause.MASKED, record=record.name, instant_s=at_s, text=text, next_command=DIAGNOSE)
    if record.name in evidence.used_to_s:
        at_s = evidence.used_to_s[record.name]
        text = f"Record {record.name} is followed and used up to {at_s:.4g} s only"
        yield _loss_reason(Cause.USED_IN_PART, record.name, at_s, text, evidence)
        return
    fitted = {quantity: c for quantity, c in record.channels.items() if c.use == "estimate" and not c.is_followed}
    for quantity, channel in fitted.items():
        of = "" if len(record.channels) == 1 else f" ({quantity})"
        if channel.out_of_step_at_s is not None:
            at_s = channel.out_of_step_at_s
            text = f"Record {record.name}{of}: the model falls out of step with the measurement at {at_s:.4g} s"
            yield _loss_reason(Cause.OUT_OF_STEP, record.name, at_s, text, evidence)
        elif channel.lost_at_s is not None:
            text = (
                f"Record {record.name}{of} is not followed at {channel.lost_at_s:.4g} s, and over "
                f"{100.0 - channel.followed_percent:.2g} % of it in total"
            )
            yield _loss_reason(Cause.NOT_FOLLOWED, record.name, channel.lost_at_s, text, evidence)
        return


def _excess_reasons(fit: Fit, evidence: Evidence) -> Iterator[Reason]:
    """Yield a reason for each fitted record with a residual far above its noise and above the other records' ratios.

    At a raised noise level such a record still counts as followed, and loses its weight in the fit.
    """
    fitted = {name: r for name, r in fit.records.items() if name in evidence.used and not r.reading.left_out}
    for name, record in fitted.items():
        for quantity, channel in record.channels.items():
            others = [
                _noise_ratio(r.channels[quantity]) for n, r in fitted.items() if n != name and quantity in r.channels
            ]
            # The median, so that one other record with an event does not hide this one.
            over, usual = _noise_ratio(channel), max(statistics.median(others), 1.0) if others else math.inf
            if channel.use != "estimate" or not over > GRADE.record_excess * usual:
                continue
            of = "" if len(record.channels) == 1 else f" ({quantity})"
            text = (
                f"Record {name}{of}: the residual is {over:.3g} times its noise, that of the other records {usual:.3g} "
                f"times theirs; it is largest at {channel.worst_at_s:.4g} s. This record contains an event that the "
                "model lacks; the fit treats it as noise."
            )
            at_s = channel.worst_at_s
            yield Reason(cause=Cause.UNEXPLAINED, record=name, instant_s=at_s, text=text, next_command=DIAGNOSE)
            break


def _noise_ratio(channel: ChannelFit) -> float:
    """Return the ratio of a channel's residual to its noise level before the fit."""
    return channel.residual_rms / channel.initial_noise if channel.initial_noise > 0.0 else math.inf


def _held_out_reasons(fit: Fit, evidence: Evidence) -> Iterator[Reason]:
    """Yield a reason for each held-out record that is predicted far worse than its noise and the fitted ones."""
    fitted = [r.channels for name, r in fit.records.items() if name in evidence.used]
    for record in (r for r in fit.records.values() if r.use == "validate" and not r.reading.left_out):
        for quantity, channel in record.channels.items():
            level = max(channel.initial_noise, channel.noise_sigma)
            left = max((c[quantity].residual_over_noise for c in fitted if quantity in c), default=1.0)
            if channel.residual_rms <= GRADE.held_out_excess * level * max(left, 1.0):
                continue
            of = "" if len(record.channels) == 1 else f" ({quantity})"
            # Not (a >= b), so that a NaN of a failed simulation counts as lost.
            is_lost = not channel.fit_percent >= 100.0 * (1.0 - GRADE.held_out_lost_share)
            text = (
                f"Record {record.name}{of} was held out: its residual is {channel.residual_over_noise:.3g} times its "
                f"noise, that of fitted records at most {left:.3g} times theirs"
            )
            text += f"; that is {100.0 - channel.fit_percent:.3g} % of the measured signal." if is_lost else "."
            cause = Cause.HELD_OUT_LOST if is_lost else Cause.HELD_OUT
            yield Reason(cause=cause, record=record.name, text=text, next_command=DIAGNOSE)
            break


def _loss_reason(cause: Cause, record: str, at_s: float, text: str, evidence: Evidence) -> Reason:
    """Return the reason that a record is not followed: place, events there, and next command."""
    happens = evidence.circumstances(record, at_s)
    again = f"mechid identify {evidence.campaign} --out DIR --seed {evidence.seed + 1}"
    return Reason(
        cause=cause,
        record=record,
        instant_s=at_s,
        text=f"{text}{f': {happens}' if happens else ''}.",
        next_command=again if cause is Cause.USED_IN_PART else DIAGNOSE,
    )


def _value_reason(name: str, text: str, again: str) -> Reason:
    """Return the reason that no start explains the records with the file's value of a parameter."""
    next_command = f"{again}, with the right unit, value or bounds of {name} in the mechanism file"
    return Reason(cause=Cause.VALUE_CONTRADICTED, parameter=name, text=text, next_command=next_command)


def _bound_reason(p: ParameterEstimate, again: str) -> Reason:
    """Return the reason that the records put a parameter beyond its bound."""
    at = f"{p.value:.6g} {p.unit}".rstrip()
    text = f"{p.name} is held at {at}: {p.reason}. This shifts the other values."
    of_file = any(limit is not None and math.isclose(p.value, limit, rel_tol=1e-6) for limit in (p.min, p.max))
    wider = f", with a wider range of {p.name} in the mechanism file" if of_file else ", with another friction law"
    return Reason(cause=Cause.BOUND_CONTRADICTED, parameter=p.name, text=text, next_command=again + wider)


def _physical_limit_reason(p: ParameterEstimate) -> Reason:
    """Return the reason that a parameter is at a limit of physics, such as a damping of 0.

    This is no contradiction by itself.
    """
    limit = p.min if p.min is not None and abs(p.value - p.min) <= abs(p.value - (p.max or 0.0)) else p.max
    at, interval = f"{limit:g} {p.unit}".rstrip(), p.ci95
    like = NEGATIVE_LOSS.get(table_of(p.name), "")
    text = f"{p.name} is held at {at}: {p.reason}. The model lacks an effect that acts like less of it"
    text += f" ({like})" if like else ""
    if interval is not None:
        text += f"; its 95 % interval is one-sided, {interval[0]:.3g} to {interval[1]:.3g} {p.unit}".rstrip()
    text += ". The possible shift of the other values is included in their errors."
    return Reason(cause=Cause.PHYSICAL_LIMIT, parameter=p.name, text=text, next_command=DIAGNOSE)


def _search_reasons(fit: Fit, evidence: Evidence) -> Iterator[Reason]:
    """Yield the doubts that the end of the search leaves."""
    again = f"mechid identify {evidence.campaign} --out DIR --seed {evidence.seed + 1}"
    fall = evidence.predicted_reduction
    if fit.outcome is FitOutcome.EVENT_MISSED:
        yield Reason(cause=Cause.EVENT_MISSED, text=fit.outcome.value, next_command=again)
    if fit.outcome is FitOutcome.NOT_CONVERGED and not fall <= GRADE.near_optimum * evidence.cost:
        text = f"{fit.outcome.value} The sum of squares could still fall by {_percent(fall, evidence.cost)}."
        yield Reason(cause=Cause.NOT_CONVERGED, text=text, next_command=again)
    elif fit.outcome.has_stopped_short and fall > SEARCH.notable_fall:
        text = (
            f"{fit.outcome.value} The predicted step that was not reached (a fall of the cost by {fall:.3g}) "
            f"is included in the standard errors.{_near_bounds(fit)}"
        )
        at = Cause.THRESHOLD if fit.outcome is FitOutcome.CLIFF else Cause.NEAR_OPTIMUM
        yield Reason(cause=at, text=text, next_command=again)


def _near_bounds(fit: Fit) -> str:
    """Name the free parameters that are close to a bound of the file, except 0, which mostly is a limit of physics."""
    said = []
    for p in fit.parameters.values():
        limits = [limit for limit in (p.min, p.max) if limit is not None and math.isfinite(limit)]
        if p.std_error is None or len(limits) < 2:
            continue
        reach = GRADE.near_bound * (limits[1] - limits[0])
        near = [limit for limit in limits if limit != 0.0 and abs(p.value - limit) < reach]
        said += [f"{p.name} = {p.value:.6g} is at its bound {limit:g}" for limit in near]
    return f" {'; '.join(said)}: the optimum may lie beyond; if so, give a wider range." if said else ""


def _unexplained_reasons(fit: Fit, evidence: Evidence) -> Iterator[Reason]:
    """Yield channels whose residual differs from their noise level, where no parts of records can show the cause."""
    for record in fit.records.values():
        for quantity, channel in record.channels.items():
            fitted = record.name in evidence.used and channel.use == "estimate"
            ratio = _noise_ratio(channel)
            if not fitted or GRADE.least_of_noise <= ratio <= NOISE.misfit:
                continue
            size = f"{ratio:.3g} times the noise"
            if ratio < GRADE.least_of_noise:
                size = f"{size} declared, so the declared level is too high"
            text = (
                f"Record {record.name} ({quantity}): the residual is {size}. Without steps and without a second record "
                "coloured noise cannot be distinguished from model error; the standard errors count it as noise."
            )
            level = f"mechid identify {evidence.campaign} --out DIR, with the right noise_sigma of record {record.name}"
            then = level if ratio < GRADE.least_of_noise else DIAGNOSE
            yield Reason(cause=Cause.UNEXPLAINED, record=record.name, text=text, next_command=then)


def _percent(fall: float, cost: float) -> str:
    return f"{100.0 * fall / cost:.2g} %" if cost > 0.0 and math.isfinite(fall) else "an unknown share"


def _disagreement_reason(fit: Fit, found: Consistency, evidence: Evidence) -> Reason:
    """Return the reason that parts of the records disagree, with the growth of the standard errors by it."""
    tests: dict[str, Scatter | None] = {"phase": found.phase, "record": found.record, "time": found.time}
    said = [
        f"between {PART_WORDS[key]} {test.ratio:.3g} times" for key, test in tests.items() if test and not test.agrees
    ]
    most, middle = error_growth(fit.parameters)
    whose = (found.parameter, found.contested_record and f"record {found.contested_record}")
    contested = " and ".join(filter(None, whose))
    text = (
        f"The model lacks an effect: the values by parts of the records scatter {', '.join(said)} as much as noise "
        f"explains{f'; the largest disagreement is on {contested}' if contested else ''}."
    )
    if most is not None and middle is not None:
        text += f" The standard errors include this: they grow by {most:.3g} at most and by {middle:.3g} in the median."
    return Reason(
        cause=Cause.PARTS_DISAGREE,
        record=found.contested_record,
        parameter=found.parameter,
        text=text,
        widened_most=most,
        widened_median=middle,
        next_command=DIAGNOSE,
    )


def error_growth(parameters: Mapping[str, ParameterEstimate]) -> tuple[float | None, float | None]:
    """Return the largest and the median ratio of standard errors to those by noise alone; None without such errors."""
    ratios = [p.std_error / p.std_error_noise for p in parameters.values() if p.std_error and p.std_error_noise]
    return (max(ratios), statistics.median(ratios)) if ratios else (None, None)
