"""Results of a fleet as one plain dict, the content of fleet.json."""

from __future__ import annotations

import os
import platform
from collections.abc import Mapping
from dataclasses import asdict
from datetime import date
from importlib.metadata import version
from pathlib import Path
from typing import Any
from urllib.parse import quote

from mechid.fleets.cautions import cautions
from mechid.fleets.estimates import Estimate
from mechid.fleets.fleet import Fleet, FleetParameter
from mechid.fleets.members import Member
from mechid.fleets.significance import FdrResult
from mechid.fleets.trends import Trend, first_day, numbers
from mechid.fleets.unit_run import ORIGIN_WORDS, UnitRun
from mechid.reports.files import PAGE_NAME
from mechid.units import angle_difference

FORMAT = "mechid-fleet/1"


def fleet_data(fleet: Fleet, out: Path | str) -> dict[str, Any]:
    """Return all results of a fleet; folders of campaigns are relative to `out`, except on another drive."""
    asked = fleet.asked
    each = zip(asked.members, fleet.runs, fleet.estimates, strict=True)
    return {
        "format": FORMAT,
        "synthetic": any(e is not None and e.synthetic for e in fleet.estimates),
        "false_discovery_rate": asked.false_discovery_rate,
        "units": list(asked.units),
        "covariates": list(asked.covariates),
        "before_after": [list(pair) for pair in asked.before_after],
        "failed": list(fleet.failed),
        "campaigns": [_campaign(member, run, estimate, Path(out)) for member, run, estimate in each],
        "parameters": [_parameter(fleet, p) for p in fleet.parameters],
        "trends": [_trend(fleet, one) for one in fleet.trends],
        "groups": [_test_numbers(one) for one in fleet.groups],
        "changes": [_test_numbers(one) for one in fleet.changes],
        "mean_changes": [_test_numbers(one) for one in fleet.mean_changes],
        "cautions": list(cautions(fleet)),
        "provenance": {"versions": {"mechid": version("mechid"), "python": platform.python_version()}},
    }


def _relative_folder(out: Path, folder: Path) -> str | None:
    """Return a folder relative to a page in `out`; None on another drive.

    Symbolic links are not resolved, because a browser applies `..` to the address as written.
    """
    try:
        return Path(os.path.relpath(folder, out)).as_posix()
    # Raised on Windows, where no relative path leads to another drive.
    except ValueError:
        return None


def _campaign(member: Member, run: UnitRun, estimate: Estimate | None, out: Path) -> dict[str, Any]:
    folder = Path(run.folder)
    shown, has_report = _relative_folder(out, folder), (folder / PAGE_NAME).is_file()
    return {
        "label": member.label,
        "unit": member.unit,
        "group": member.group,
        "state": member.state,
        "covariates": {n: v.isoformat() if isinstance(v, date) else v for n, v in member.covariates.items()},
        "source": str(member.source),
        "folder": str(folder.absolute()) if shown is None else shown,
        "report": has_report,
        "link": None if shown is None or not has_report else quote(f"{shown}/{PAGE_NAME}"),
        "how": str(run.how),
        "how_words": ORIGIN_WORDS[run.how],
        "said": run.said,
        "wall_time_s": run.seconds,
        "grade": None if estimate is None else str(estimate.grade),
        "reason": run.said if estimate is None else estimate.said,
    }


def _parameter(fleet: Fleet, p: FleetParameter) -> dict[str, Any]:
    o, made = p.observed, p.spread
    return {
        "name": p.name,
        "unit": o.unit,
        "campaigns": len(o.members),
        "units": len(p.level.units),
        "lacking": list(p.lacking),
        "differs": p.differs,
        "equal_q": p.equal_q,
        "along": None if p.along is None else {"covariate": p.along.covariate, **_reference(fleet, p.along)},
        **(dict.fromkeys(SPREAD) if made is None else _spread(p)),
        "outliers": [] if made is None else [_outlier(p, one.unit, one.p_value) for one in p.outliers],
        "values": [_value(p, m, e) for m, e in zip(fleet.asked.members, fleet.estimates, strict=True)],
    }


SPREAD = ("mean", "std_error", "mean95", "spread", "spread95", "next95", "repeatability", "equal_p")
"""Entries of a parameter that are null without a spread."""


def _spread(p: FleetParameter) -> dict[str, Any]:
    """Return mean and spread; the mean of an angle in [-180, 180), its intervals around it."""
    made, turn = p.spread, _turn(p)
    assert made is not None
    return {
        "mean": made.mean + turn,
        "std_error": made.error,
        "mean95": [end + turn for end in made.mean95],
        "spread": made.spread,
        "spread95": list(made.spread95),
        "next95": [end + turn for end in made.next95],
        "repeatability": made.unit_values.repeatability,
        "equal_p": made.equal_p,
    }


def _turn(p: FleetParameter) -> float:
    """Return the full turns that bring the mean of an angle to [-180, 180)."""
    if p.spread is None or not p.observed.is_angle:
        return 0.0
    return angle_difference(p.spread.mean) - p.spread.mean


def _outlier(p: FleetParameter, k: int, p_value: float) -> dict[str, Any]:
    made = p.spread
    assert made is not None
    standing = next(one for one in made.standings if one.unit == k)
    return {
        "unit": made.unit_values.units[k],
        "value": float(made.unit_values.values[k]),
        "off": standing.off,
        "p_value": p_value,
    }


def _value(p: FleetParameter, member: Member, estimate: Estimate | None) -> dict[str, Any] | None:
    """Return a campaign's value; None if its mechanism lacks the parameter.

    `level` is the value for comparing units: without the trend, an angle on the branch of the mean.
    """
    value = estimate.values.get(p.name) if estimate else None
    if value is None:
        return None
    level = next((float(v) for m, v in zip(p.level.members, p.level.values, strict=True) if m is member), None)
    return {
        "value": value.value,
        "std_error": value.std_error,
        "status": value.status,
        "left_out": value.left_out,
        "near_threshold": value.near_threshold,
        "level": None if level is None else level + _turn(p),
        "off": None if level is None or p.spread is None else p.spread.standardized_distance(level, value.error),
    }


def _reference(fleet: Fleet, found: Trend) -> dict[str, Any]:
    first = first_day(fleet.asked.members, found.covariate)
    return {"reference": found.reference, "first_day": first.isoformat() if first else None}


def _trend(fleet: Fleet, one: FdrResult[Trend]) -> dict[str, Any]:
    """Return a trend with its data points, the covariate as a number."""
    found = one.result
    o = next(p.observed for p in fleet.parameters if p.name == found.name)
    first = first_day(fleet.asked.members, found.covariate)
    has = [k for k, m in enumerate(o.members) if found.covariate in m.covariates]
    return {
        **_test_numbers(one),
        **_reference(fleet, found),
        "points": {
            "campaigns": [o.members[k].label for k in has],
            "covariate": numbers([o.members[k].covariates[found.covariate] for k in has], first).tolist(),
            "value": o.values[has].tolist(),
            "error": o.errors[has].tolist(),
        },
    }


def _test_numbers(one: FdrResult[Any]) -> Mapping[str, Any]:
    entries = {key: list(value) if isinstance(value, tuple) else value for key, value in asdict(one.result).items()}
    return {**entries, "q": one.q, "found": one.found}
