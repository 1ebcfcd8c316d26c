"""Conclusion of a search: the `Fit` with statuses, uncertainty, records, warnings and provenance."""

from __future__ import annotations

import math
import platform
from collections.abc import Callable, Mapping
from dataclasses import replace
from importlib.metadata import version

import numpy as np

from mechid.campaign import Campaign
from mechid.campaign.campaign import is_start_name
from mechid.identification.added_terms import add_missing_entries, incomplete_reason
from mechid.identification.effects.disturbance import disturbed_campaign, lines_by_record, with_lines
from mechid.identification.effects.mains import find_grid_hz
from mechid.identification.grading import Evidence, grade_fit
from mechid.identification.held_out_nuisance import fit_held_out_records
from mechid.identification.output_error.declaration import DECLARED, reinterpret_campaign
from mechid.identification.output_error.digests import file_digests
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.reduction import Triangle
from mechid.identification.output_error.settings import PROBLEM
from mechid.identification.result.fit import Fit
from mechid.identification.result.grade import FitOutcome
from mechid.identification.result.missing_effects import EffectValue, missing_entry, missing_warning
from mechid.identification.result.parameter_estimate import ParameterEstimate, PriorShare
from mechid.identification.result.record_fit import record_fit
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.solve import predicted_reduction
from mechid.identification.stages.departure import departure
from mechid.identification.uncertainty.draws import LowerPoint
from mechid.identification.uncertainty.further_errors import clock_warnings
from mechid.identification.uncertainty.noise_levels import raised_level_warnings
from mechid.identification.uncertainty.standard_errors import ParameterErrors, StandardErrors, standard_errors
from mechid.identification.uncertainty.verdict import Verdict, describe_unknown, judge
from mechid.identification.uncertainty.visibility import ambiguity_notes
from mechid.parameter import Parameter, Status
from mechid.plant.mechanism import Mechanism

ONE_RECORD = "One record only: the effect of other conditions on the values is not tested."
MAINLY_PRIOR = "its standard error is mainly its prior's"
GoOn = Callable[[SearchState, LowerPoint], SearchState | None]
PACKAGES = ("mechid", "numpy", "scipy", "numba", "sympy")


def conclude(campaign: Campaign, state: SearchState, seed: int, seconds: float, go_on: GoOn = lambda *_: None) -> Fit:
    """Return the fit at the end of a search of any outcome; `seconds` is the duration of the search.

    Where a draw within the errors has a lower cost than the estimate, `go_on` continues the search from there. If it
    returns None, the fit has not converged.
    """
    problem, windows, readings = state.problem, state.windows, state.readings
    declared = campaign
    written = disturbed_campaign(reinterpret_campaign(campaign, readings), [found.disturbance for found in state.found])
    hum = lines_by_record(problem, [record.name for record in written.records])
    written = replace(written, records=tuple(with_lines(record, hum[record.name]) for record in written.records))
    campaign = replace(written, mechanism=state.added.mechanism) if state.added else written
    # A point that cannot be simulated has no sensitivities.
    with np.errstate(all="ignore"):
        triangle = problem.joint(state.q, windows)
    verdict = judge(campaign, problem, state.q, windows, triangle, {f.name: f.reason for f in state.frozen})
    q = verdict.q
    errors = standard_errors(state, seed, triangle, verdict, clock_declared=campaign.clock_reference is not None)
    # Tested first: a continued search changes all that is computed below.
    if errors.lower is not None:
        further = go_on(state, errors.lower)
        if further is not None:
            return conclude(declared, further, seed, seconds, go_on)
        state = state.with_outcome(FitOutcome.NOT_CONVERGED).with_warnings(_lower_warning(errors.lower))
    evidence = _evidence(campaign, state, seed, triangle, verdict, errors.lower)
    # The mechanism keeps the found values also of parameters that are declared unknown next.
    mechanism = _mechanism(campaign, problem, verdict)
    errors, verdict = _freeze_unknown(campaign, problem, errors, verdict)
    parameters = _estimates(campaign, problem, mechanism, verdict, errors)
    added = mechanism.parameters.keys() - written.mechanism.parameters.keys()
    parameters = {name: _mark_added(p, state) if name in added else p for name, p in parameters.items()}
    records = {
        r.name: replace(record_fit(r, problem, q, windows), reading=readings.get(r.name, DECLARED))
        for r in campaign.records
        if r.data is not None
    }
    values = {n: EffectValue(value=p.value, std_error=p.std_error, unit=p.unit) for n, p in parameters.items()}
    missing = tuple(missing_entry(found, values, records) for found in state.found)
    own = [*map(missing_warning, missing), *_warnings(parameters)]
    raised = raised_level_warnings(campaign, problem.targets, state.before_raised)
    masked = [f"record {r.name}: {r.describe_masked()}" for r in records.values() if r.masked]
    fit = Fit(
        mechanism=mechanism,
        parameters=parameters,
        correlation_names=errors.names,
        correlation=errors.correlation,
        covariance=errors.covariance,
        records=records,
        stages=state.stages,
        outcome=state.outcome,
        warnings=(
            *campaign.warnings,
            *raised,
            *masked,
            *state.warnings,
            *errors.warnings,
            *own,
            *clock_warnings(parameters),
        ),
        notes=(*ambiguity_notes(written), *((ONE_RECORD,) if len(windows) == 1 else ()), *_start_notes(campaign)),
        provenance=_provenance(campaign, state, seed, seconds),
        consistency=errors.consistency,
        missing=missing,
        mains_hz=None if evidence.lost or state.outcome is FitOutcome.INTERRUPTED else find_grid_hz(problem, q),
        synthetic=campaign.synthetic,
        path=state.path,
    )
    fit = add_missing_entries(fit_held_out_records(fit, written, state), written, state)
    return grade_fit(fit, replace(evidence, incomplete=incomplete_reason(fit, written, state)))


def _lower_warning(lower: LowerPoint) -> str:
    return (
        f"a draw within the standard errors has a cost {lower.gain:.3g} lower than the estimate, although the search "
        "continued from such draws before: the cost has many small minima here, and the lowest was not found; try "
        "another seed"
    )


def _evidence(
    campaign: Campaign,
    state: SearchState,
    seed: int,
    triangle: Triangle,
    verdict: Verdict,
    lower: LowerPoint | None,
) -> Evidence:
    """Return the evidence for the grade that the fit itself does not hold."""
    problem, windows, lost = state.problem, state.windows, not math.isfinite(triangle.norm)
    targets = {t.name: t for t in problem.targets}

    def circumstances(record: str, at_s: float) -> str:
        base = targets[record].base
        sample = min(max(round((at_s - base.start_s) * base.sample_rate_hz), 0), base.samples)
        return departure(problem, verdict.q, targets[record], sample)

    used_to_s = {
        name: targets[name].base.start_s + stop / targets[name].base.sample_rate_hz
        for name, (_, stop) in windows.items()
        if not campaign.stages and stop < targets[name].samples
    }
    return Evidence(
        campaign=str(campaign.path),
        used=windows,
        used_to_s=used_to_s,
        predicted_reduction=math.nan
        if lost
        else max(predicted_reduction(triangle, verdict.counted), lower.gain if lower else 0.0),
        cost=triangle.cost,
        lost=lost,
        contradicted=state.contradicted,
        circumstances=circumstances,
        seed=seed,
    )


def _freeze_unknown(
    campaign: Campaign, problem: Problem, errors: StandardErrors, verdict: Verdict
) -> tuple[StandardErrors, Verdict]:
    """Freeze the parameters that no record determines, and remove their errors."""
    own = {p.name: p for record in campaign.estimated for p in record.parameters}
    values = problem.coordinates.values(verdict.q)
    found = {}
    for name in errors.names:
        parameter = campaign.mechanism.parameters.get(name) or own[name]
        sigma = errors.errors_of(name).total
        reason = describe_unknown(parameter, values[name], sigma) if sigma is not None else ""
        if reason:
            found[name] = Status.FROZEN, reason
    return errors.drop(found), replace(verdict, reasons={**verdict.reasons, **found})


def _mechanism(campaign: Campaign, problem: Problem, verdict: Verdict) -> Mechanism:
    """Return the campaign's mechanism with the estimated values; others keep their value to the bit."""
    # A frozen value went through search coordinates and back, which rounds it: the file's value is restored.
    found = problem.space.values(verdict.q[: problem.space.size])
    starts = {name: campaign.mechanism.value(name) for name in found}
    frozen = {name for name, (status, _) in verdict.reasons.items() if status is Status.FROZEN}
    back = {n: v for n, v in starts.items() if n in frozen and math.isclose(v, found[n], rel_tol=1e-9)}
    return campaign.mechanism.with_values({**found, **back})


def _estimates(
    campaign: Campaign,
    problem: Problem,
    mechanism: Mechanism,
    verdict: Verdict,
    errors: StandardErrors,
) -> dict[str, ParameterEstimate]:
    out = {}
    for name, before in campaign.mechanism.parameters.items():
        start = campaign.mechanism.value(name)
        out[name] = _estimate(before, mechanism.value(name), start, verdict, errors)
    for record in campaign.estimated:
        target = next(t for t in problem.targets if t.name == record.name)
        values = {p.name: problem.coordinates.value(p, verdict.q) for p in target.own}
        out |= {p.name: _estimate(p, values[p.name], p.value, verdict, errors) for p in record.parameters if p.is_free}
    return out


def _estimate(
    before: Parameter, value: float, start: float, verdict: Verdict, errors: StandardErrors
) -> ParameterEstimate:
    status, reason = before.status, before.reason
    if before.is_free:
        status, reason = verdict.reasons.get(before.name, (Status.FREE, ""))
    if before.tied_to:
        reason = f"follows {before.tied_to}"
    own = errors.errors_of(before.name) if status is Status.FREE else ParameterErrors()
    bounded_at = errors.on_bounds.get(before.name) if status is Status.AT_BOUND else None
    excluded = bounded_at is not None and bounded_at.is_contradicted
    physical = excluded and _is_limit_of_physics(before, value)
    beyond = f"the records put it {bounded_at.beyond:.3g} standard errors beyond" if excluded and bounded_at else ""
    local = errors.local_only.get(before.name, "") if own.total is not None else ""
    bounded = before.is_free and not before.is_periodic
    prior = _prior(before, start, errors)
    mainly = MAINLY_PRIOR if prior and prior.dominates else ""
    return ParameterEstimate(
        name=before.name,
        symbol=before.declaration.symbol,
        unit=before.declaration.unit,
        value=value,
        std_error=own.total,
        std_error_noise=own.noise,
        std_error_white=own.white,
        std_error_clock=own.clock,
        dof=own.dof,
        start=start,
        min=before.min if bounded else None,
        max=before.max if bounded else None,
        status=str(status),
        reason="; ".join(filter(None, (reason, beyond, local, mainly))),
        local_only=bool(local),
        prior=prior,
        contradicted=excluded and not physical,
        one_sided=bounded_at.interval if bounded_at and (physical or not excluded) else None,
        at_physical_limit=physical,
    )


def _mark_added(p: ParameterEstimate, state: SearchState) -> ParameterEstimate:
    """Mark a parameter as belonging to an added term, with the small prior of that term, if it had one."""
    width = state.added.widths.get(p.name) if state.added else None
    return replace(p, added=True, prior=None if width is None else PriorShare(value=0.0, sigma=width, counted=True))


def _is_limit_of_physics(p: Parameter, value: float) -> bool:
    """Tell whether a parameter is on a bound that physics sets, such as a damping or a friction of 0."""
    reach = PROBLEM.on_bound * (p.max - p.min) if math.isfinite(p.max - p.min) else 0.0
    lowest = p.min == p.declaration.lower and value - p.min <= reach
    highest = p.max == p.declaration.upper and p.max - value <= reach
    return lowest or highest


def _start_notes(campaign: Campaign) -> tuple[str, ...]:
    """Name the records whose start state is estimated."""
    begun = {r.name: sum(q.is_free for q in r.start) for r in campaign.estimated if r.start}
    if not begun:
        return ()
    names, count = f"record{'s' * (len(begun) > 1)} {', '.join(begun)}", sum(begun.values())
    where = "the parameters record.<name>.start.<state> of estimate.json"
    return (f"{names}: the start state is estimated too, {count} numbers; see {where}",)


def _prior(before: Parameter, value: float, errors: StandardErrors) -> PriorShare | None:
    """Return the prior of an estimated parameter and its standard error by the records alone; None without a prior."""
    if not before.is_free or before.sigma is None:
        return None
    alone = errors.error_without_priors(before.name)
    return PriorShare(value=value, sigma=before.sigma, std_error_without=alone, counted=alone is not None)


def _warnings(parameters: Mapping[str, ParameterEstimate]) -> list[str]:
    """Warn of parameters without an uncertainty of their own, and of those whose uncertainty is mainly their prior's.

    Start states of records are left out: they are in the table, and no later command uses them.
    """
    parameters = {name: p for name, p in parameters.items() if not is_start_name(name)}
    said = (Status.FROZEN, Status.AT_BOUND)
    lines = [
        f"{p.name}: {p.status.replace('_', ' ')} at {p.value:.6g} {p.unit}: {p.reason}"
        for p in parameters.values()
        if p.status in said
    ]
    return lines + [
        f"{p.name}: {MAINLY_PRIOR}, {p.prior.sigma:.3g} {p.unit}; from the records alone it would be "
        f"{p.prior.std_error_without:.3g} {p.unit}; add a record that excites it more"
        for p in parameters.values()
        if p.prior and p.prior.dominates
    ]


def _provenance(campaign: Campaign, state: SearchState, seed: int, seconds: float) -> dict[str, object]:
    return {
        "versions": {name: version(name) for name in PACKAGES} | {"python": platform.python_version()},
        "inputs_sha256": file_digests(campaign),
        "records": {r.name: r.data.provenance for r in campaign.records if r.data is not None},
        "test": campaign.test.to_dict(),
        "seed": seed,
        "substeps": state.problem.substeps,
        "wall_time_s": seconds,
        "plant": state.problem.space.mechanism.plant.digest,
    }
