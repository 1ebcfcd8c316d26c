"""Disturbances of a campaign: possible ones that it does not declare, and those found by an earlier fit."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

from mechid.arrays import FloatArray
from mechid.campaign import Campaign, CampaignRecord
from mechid.campaign.campaign import CAMPAIGN, CLOCK, TIME_OFFSET, key_in_record, record_parameter_name
from mechid.campaign.identify_options import DISTURBANCES, MAINS, ONE_CLOCK
from mechid.command import MeasuredCommand
from mechid.identification.effects.disturbance import Disturbance, with_parameters
from mechid.identification.effects.effect import distance_from_null
from mechid.identification.effects.mains import NO_RESTS, grid_at_rest, mains
from mechid.identification.effects.settings import PRIORS
from mechid.identification.output_error.misfit import Window
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target
from mechid.parameter import Declaration, Parameter, Role, Status
from mechid.plant.plant import Plant


def possible_disturbances(
    problem: Problem, campaign: Campaign, q: FloatArray | None = None, rests: Mapping[str, Window] = NO_RESTS
) -> tuple[Disturbance, ...]:
    """Return the disturbances that records of a problem may have, except declared and excluded ones.

    Mains hum is included if the longest record shows it: in the residual of the model at `q`, or before any model; or
    if records show it before they move, in `rests`, first and last-plus-one sample by name.
    """
    asked = campaign.options.disturbances
    allowed = DISTURBANCES if asked == "auto" else () if asked == "none" else asked
    # Records driven by their own channels have neither a driver's clock nor a delay of a command.
    stepped = tuple(t for t in problem.targets if not isinstance(t.command, MeasuredCommand))
    found = (one for name in allowed if name != MAINS for one in _MAKERS[name](problem, stepped))
    hum = mains(problem, q) if MAINS in allowed else None
    if hum is None and rests and MAINS in allowed:
        grid = grid_at_rest(problem, rests)
        hum = mains(problem, q, grid, rests) if grid else None
    return tuple(one for one in (*found, hum) if one and one.records)


def _clock(problem: Problem, stepped: tuple[Target, ...]) -> Iterator[Disturbance]:
    if any(t.clocks for t in stepped):
        return
    own = _free(f"{CAMPAIGN}.{CLOCK.key}", CLOCK, 0.0, PRIORS.clock_ppm)
    words = "the driver's clock and the recorder's do not run at the same rate"
    yield Disturbance(ONE_CLOCK, words, {t.name: (own,) for t in stepped})


def _own_clocks(problem: Problem, stepped: tuple[Target, ...]) -> Iterator[Disturbance]:
    # With a single record, its own clock equals the common one.
    if any(t.clocks for t in stepped) or len(stepped) < 2:
        return
    names = {t.name: record_parameter_name(t.name, CLOCK.key) for t in stepped}
    own = {record: (_free(name, CLOCK, 0.0, PRIORS.clock_ppm),) for record, name in names.items()}
    yield Disturbance(
        "record.clock", "the driver's clock, or the recorder's, runs at another rate in some records", own
    )


def _delay(problem: Problem, stepped: tuple[Target, ...]) -> Iterator[Disturbance]:
    known = [t for t in stepped if not t.time_offset.is_free]
    own = {
        t.name: (_free(t.time_offset.name, t.time_offset.declaration, t.time_offset.value, PRIORS.delay_s),)
        for t in known
    }
    yield Disturbance("record.delay", "the records start earlier or later than their commands", own)


def _of_role(role: Role, name: str, words: str) -> Callable[[Problem, tuple[Target, ...]], Iterator[Disturbance]]:
    """Return a function that makes the disturbance in which each record has its own value of a role's parameter."""

    def make(problem: Problem, stepped: tuple[Target, ...]) -> Iterator[Disturbance]:
        mechanism = problem.space.mechanism
        keys = {name: key for key, name in mechanism.plant.of_record.items()}
        for parameter in (n for n in mechanism.plant.names_with_role(role) if n in keys):
            declared = any(p.replaces == parameter for t in problem.targets for p in t.own)
            # With a single record, its own value could not be distinguished from the mechanism's.
            if declared or len(problem.targets) < 2 or not mechanism.value(parameter):
                continue
            shared, sigma = mechanism.parameters[parameter], PRIORS.shares[role] * abs(mechanism.value(parameter))
            made = _free("", shared.declaration, shared.value, sigma)
            if shared.is_free:
                made = replace(made, min=shared.min, max=shared.max)
            names = {t.name: record_parameter_name(t.name, keys[parameter]) for t in problem.targets}
            own = {t: (replace(made, name=own_name, replaces=parameter),) for t, own_name in names.items()}
            yield Disturbance(name, words, own)

    return make


def _free(name: str, declaration: Declaration, value: float, sigma: float) -> Parameter:
    low, high = (
        max(value - PRIORS.reach * sigma, declaration.lower),
        min(value + PRIORS.reach * sigma, declaration.upper),
    )
    return Parameter(
        name=name, value=value, declaration=declaration, min=low, max=high, sigma=sigma, status=Status.FREE
    )


def widen_priors(
    some: tuple[Disturbance, ...], problem: Problem, q: FloatArray, edge: float, factor: float
) -> tuple[Disturbance, ...]:
    """Return disturbances with wider priors where a record's value is at the edge of its own.

    All records of such a disturbance get the wider prior, and a range as wide, within the limits of real hardware. The
    same tuple is returned if no value is at the edge, or none may be wider.

    Parameters
    ----------
    some : tuple of Disturbance
        Disturbances of the problem.
    problem : Problem
    q : (n,)
    edge : float
        Deviation from its prior, in standard deviations, at which a value counts as at the edge.
    factor : float
        Factor by which the prior is widened.
    """
    off = dict(
        zip(
            problem.coordinates.record_parameter_names,
            distance_from_null(problem, q)[problem.space.size :].tolist(),
            strict=True,
        )
    )

    def wider(one: Disturbance) -> Disturbance:
        if not any(p.sigma and abs(off.get(p.name, 0.0)) > edge * p.sigma for p in one.parameters):
            return one
        own = {name: tuple(_wider(p, problem, factor) for p in parameters) for name, parameters in one.own.items()}
        return one if own == one.own else replace(one, own=own)

    found = tuple(map(wider, some))
    return some if all(a is b for a, b in zip(found, some, strict=True)) else found


def _wider(p: Parameter, problem: Problem, factor: float) -> Parameter:
    """Return a record's parameter with a wider prior and range; a range from the file is kept."""
    instants = {CLOCK.key: PRIORS.widest_clock_ppm, TIME_OFFSET.key: PRIORS.widest_delay_s}
    shares = {role: share * abs(p.value) for role, share in PRIORS.widest_shares.items()}
    widest = instants.get(p.declaration.key) or next((w for r, w in shares.items() if r is p.declaration.role), None)
    if widest is None or p.sigma is None or p.sigma >= widest:
        return p
    sigma, shared = min(factor * p.sigma, widest), problem.space.mechanism.parameters.get(p.replaces)
    if shared is not None and shared.is_free:
        return replace(p, sigma=sigma)
    reach = min(PRIORS.reach * sigma, widest)
    low, high = max(p.value - reach, p.declaration.lower), min(p.value + reach, p.declaration.upper)
    return replace(p, sigma=sigma, min=min(low, p.min), max=max(high, p.max))


_MAKERS: Mapping[str, Callable[[Problem, tuple[Target, ...]], Iterator[Disturbance]]] = {
    ONE_CLOCK: _clock,
    "record.clock": _own_clocks,
    "record.delay": _delay,
    "record.voltage": _of_role(Role.SUPPLY, "record.voltage", "the supply differs from record to record"),
    "record.gain": _of_role(Role.TRANSDUCER_GAIN, "record.gain", "the transducer's gain differs from record to record"),
    "record.temperature": _of_role(
        Role.WINDING_RESISTANCE,
        "record.temperature",
        "the winding's resistance, so its temperature, differs from record to record",
    ),
}


@dataclass(frozen=True, kw_only=True)
class Declared:
    """Record parameter as the fit began with it: start, bounds and prior, in its unit."""

    start: float
    min: float
    max: float
    sigma: float | None

    @classmethod
    def from_file(cls, start: float, low: float | None, high: float | None, sigma: float | None) -> Declared:
        """Return the parameter from the entries of estimate.json, in which a missing bound is null."""
        return cls(
            start=start, min=-math.inf if low is None else low, max=math.inf if high is None else high, sigma=sigma
        )


def restore_found_records(campaign: Campaign, found: Mapping[str, Declared]) -> Campaign:
    """Return a campaign whose records have the parameters that an earlier fit has found, by dotted name."""
    plant = campaign.mechanism.plant
    return replace(campaign, records=tuple(restore_found_record(r, found, plant) for r in campaign.records))


def restore_found_record(record: CampaignRecord, found: Mapping[str, Declared], plant: Plant) -> CampaignRecord:
    """Return a record with its parameters found by an earlier fit, free."""
    prefixes = f"record.{record.name}.", f"{CAMPAIGN}."
    own = (_parameter(name, given, plant) for name, given in found.items() if name.startswith(prefixes))
    return with_parameters(record, own)


def _parameter(name: str, given: Declared, plant: Plant) -> Parameter:
    key = name.removeprefix(f"{CAMPAIGN}.") if name.startswith(f"{CAMPAIGN}.") else key_in_record(name)
    instants = {d.key: d for d in (TIME_OFFSET, CLOCK)}
    replaces = "" if key in instants else plant.of_record[key]
    return Parameter(
        name=name,
        value=given.start,
        declaration=instants.get(key) or plant.declarations[replaces],
        min=given.min,
        max=given.max,
        sigma=given.sigma,
        status=Status.FREE,
        replaces=replaces,
    )
