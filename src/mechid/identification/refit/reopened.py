"""A finished fit taken up again: the problem that it solved, at its optimum."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign import Campaign
from mechid.errors import FitError, InputFileError, UsageError, did_you_mean
from mechid.identification.effects.campaign_disturbances import Declared, recalled
from mechid.identification.effects.disturbance import with_lines
from mechid.identification.effects.effect import beside_again
from mechid.identification.identify import make_problem
from mechid.identification.output_error.declaration import Reading, campaign_as_read
from mechid.identification.output_error.identity import file_digests
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.reduction import Triangle
from mechid.identification.result.grade import GRADE_WORDS, Grade
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.solve import solve
from mechid.identification.stages.freeze import without
from mechid.identification.stages.own_stages import begin
from mechid.identification.uncertainty.noise import release_noise, without_outliers
from mechid.identification.uncertainty.noise_levels import with_saved_levels
from mechid.parameter import Status

MOVED = (Status.FREE, Status.AT_BOUND)


@dataclass(frozen=True, eq=False)
class Optimum:
    """The optimum of a fit.

    Attributes
    ----------
    problem : Problem
        Its free parameters are those that the fit moved; records weigh as in its end.
    q : (n,)
    windows : mapping of str to (int, int)
    triangle : Triangle
        At `q`.
    parameters : mapping of str to mapping
        The table of estimate.json.
    """

    problem: Problem
    q: FloatArray
    windows: Windows
    triangle: Triangle
    parameters: Mapping[str, Mapping[str, Any]]

    @property
    def moved(self) -> tuple[str, ...]:
        """Names of the parameters that the fit moved."""
        return tuple(name for name, p in self.parameters.items() if p["status"] in MOVED)

    def one(self, name: str) -> Mapping[str, Any]:
        """Return the table of a parameter; UsageError where the fit did not move it."""
        if name not in self.moved:
            known = self.parameters.get(name)
            state = f"is {known['status']}" if known else f"is not in the fit{did_you_mean(name, self.moved)}"
            raise UsageError(f"--parameter {name}: {state}; the fit moved {', '.join(self.moved)}")
        return self.parameters[name]

    def values(self, q: FloatArray) -> dict[str, float]:
        """Return the file's values of the parameters that the fit moved, at a point."""
        return self.problem.coordinates.values(q)


def reopened(campaign: Campaign, estimate: Mapping[str, Any], *, workers: int = 1) -> Optimum:
    """Return the optimum that an estimate.json describes, its records' weights worked out again from the residuals.

    Raises
    ------
    InputFileError
        The campaign is not the one of the fit.
    FitError
        The fit has no optimum.
    """
    _refuse_others(campaign, estimate)
    parameters: dict[str, Any] = estimate["parameters"]
    campaign = as_fitted(campaign, estimate)
    values = {name: p["value"] for name, p in parameters.items() if p["status"] in (*MOVED, Status.FROZEN)}
    terms = estimate["beside"]["parameters"] if estimate.get("beside") else {}
    values |= {name: p["value"] for name, p in terms.items()}
    problem = _with_terms(campaign, make_problem(campaign, workers), estimate)
    problem, q, windows = _at(campaign, with_saved_levels(problem, estimate["records"]), values)
    problem, q = _as_moved(problem, q, {**_as_free(terms), **parameters}, values)
    problem = replace(problem, substeps=int(estimate["provenance"]["substeps"]))
    options = replace(campaign.options, colour="none") if campaign.stages else campaign.options
    if options.spikes == "reject" and not campaign.stages:
        problem = without_outliers(problem, q, windows)
    problem, _ = release_noise(problem, q, windows, options)
    if options.priors == "search":
        problem = replace(problem, priors={})
    solution = solve(problem, q, windows)
    if not np.all(np.isfinite(solution.triangle.jacobian)):
        raise FitError(f"{campaign.path}: the estimate cannot be simulated; identify anew")
    return Optimum(problem, solution.q, windows, solution.triangle, parameters)


def as_fitted(campaign: Campaign, estimate: Mapping[str, Any]) -> Campaign:
    """Return a campaign as its fit had it: as that read its records, and with what these had of their own."""
    return recalled(as_recorded(campaign, estimate), _found(estimate))


def as_recorded(campaign: Campaign, estimate: Mapping[str, Any]) -> Campaign:
    """Return a campaign as its fit read it: records otherwise than declared, hum removed."""
    taken = {name: Reading.from_dict(r["taken"]) for name, r in estimate["records"].items() if r.get("taken")}
    campaign, found = campaign_as_read(campaign, taken), estimate["records"]
    own = {name: p["value"] for r in found.values() for name, p in _nuisance(r).items()}
    records = (record.holding(own) for record in campaign.records)
    return replace(
        campaign,
        records=tuple(with_lines(r, _lines_removed(found[r.name])) if r.name in found else r for r in records),
    )


def _lines_removed(record: Mapping[str, Any]) -> set[float]:
    return {line[0] for channel in record["channels"].values() for line in channel.get("lines", ())}


def _nuisance(record: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return what was fitted of a held-out record on its first part, by dotted name."""
    own: Mapping[str, Any] = (record.get("nuisance") or {}).get("parameters", {})
    return own


def _as_free(names: Iterable[str]) -> dict[str, Any]:
    return {name: {"status": Status.FREE} for name in names}


def _with_terms(campaign: Campaign, problem: Problem, estimate: Mapping[str, Any]) -> Problem:
    """Return the problem with the terms that the fit had beside the mechanism as written."""
    found = estimate.get("beside")
    if not found:
        return problem
    widths = {name: p["width"] for name, p in found["parameters"].items()}
    return beside_again(campaign.mechanism, found["names"], widths).problem(problem)


def _found(estimate: Mapping[str, Any]) -> dict[str, Declared]:
    """Return the parameters that the fit had because its records asked for them, by dotted name."""
    names = (name for one in estimate.get("missing", ()) for name in one["parameters"])
    own = {name: estimate["parameters"][name] for name in names if name in estimate["parameters"]}
    return {
        name: Declared.bounded(p["start"], p["min"], p["max"], p["prior"]["sigma"] if p["prior"] else None)
        for name, p in own.items()
    }


def _at(campaign: Campaign, problem: Problem, values: Mapping[str, float]) -> tuple[Problem, FloatArray, Windows]:
    if not campaign.stages:
        return problem, problem.coordinates.point(values), problem.whole()
    state = begin(SearchState(problem, problem.start, problem.whole()), campaign, campaign.stages, values)
    return state.problem, state.q, state.windows


def _as_moved(
    problem: Problem, q: FloatArray, parameters: Mapping[str, Any], values: Mapping[str, float]
) -> tuple[Problem, FloatArray]:
    """Hold what the fit held, and search detents at their limit as it did."""
    moved = [p.name for p in problem.space.mechanism.free if parameters[p.name]["status"] in MOVED]
    known = problem.space.mechanism.parameters
    held = {n: v for n, v in values.items() if parameters[n]["status"] == Status.FROZEN and n in known}
    problem, q = without(problem, q, moved, held)
    at_limit = {c.name for c in problem.space.coordinates if c.kind == "cosine"}
    at_limit = {name for name in at_limit if parameters[name]["status"] == Status.AT_BOUND}
    return problem.in_polar(frozenset(at_limit), q) if at_limit else (problem, q)


def _refuse_others(campaign: Campaign, estimate: Mapping[str, Any]) -> None:
    """Refuse a fit of other files, and one without an optimum."""
    refuse_other_files(campaign, estimate)
    if not Grade(estimate["grade"]).good:
        said = [f"{reason['text']} Next: {reason['next_command']}" for reason in estimate["grade_reasons"][:1]]
        raise FitError(" ".join(["the fit has no optimum to look around from:", GRADE_WORDS[estimate["grade"]], *said]))


def refuse_other_files(campaign: Campaign, estimate: Mapping[str, Any]) -> None:
    """Refuse a fit that an earlier version wrote, and one of other files than the campaign has now."""
    if "grade" not in estimate:
        raise InputFileError("estimate.json: grade: missing; it was written by an earlier version, identify anew")
    if other := other_files(campaign, estimate):
        raise InputFileError(f"{campaign.path}: {', '.join(other)}: not as in the fit; identify anew")


def other_files(campaign: Campaign, estimate: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the names of a campaign's files that are not those the fit was made of."""
    found = estimate["provenance"].get("inputs_sha256", {})
    return tuple(name for name, digest in file_digests(campaign).items() if found.get(name) != digest)
