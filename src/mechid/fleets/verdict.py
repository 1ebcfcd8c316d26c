"""Verdict on a fleet: failed fits, differences, outliers, trends and changes, the most important findings first."""

from __future__ import annotations

from collections.abc import Sequence

from mechid.ink.data import Data
from mechid.ink.digits import digits, plain, with_sigma
from mechid.ink.document import BAD, CAUTION, GOOD, Lines, Verdict

SHOWN = 8
"""Findings in the verdict at most; all are in the tables."""


def fleet_verdict(data: Data) -> Verdict:
    """Return the verdict on the numbers of `fleet_data`."""
    questions = [
        ("Has every campaign an estimate to use?", _estimate_lines(data)),
        ("What differs from unit to unit?", _difference_lines(data)),
        ("Which units stand off from the others?", _outlier_lines(data)),
    ]
    if data["trends"] or data["groups"]:
        questions.append(("What does it go with?", _trend_lines(data)))
    if data["before_after"]:
        questions.append(("What has changed?", _change_lines(data)))
    warnings = Lines(data["cautions"], "caution", "Cautions", "yellow")
    return Verdict(_headline(data), questions, _tone(data), warnings)


def _tone(data: Data) -> str:
    if data["failed"]:
        return BAD
    findings = (*data["changes"], *data["mean_changes"])
    odd = any(p["outliers"] for p in data["parameters"]) or any(one["found"] for one in findings)
    return CAUTION if odd or data["cautions"] else GOOD


def _headline(data: Data) -> str:
    whole, failed = len(data["campaigns"]), len(data["failed"])
    units = len(data["units"])
    of = f"{whole} campaigns of {units} units" if units < whole else f"{whole} units"
    if failed:
        return f"{failed} of {of} have no estimate to use; what follows is of the others."
    return f"All {of} have an estimate to use."


def _estimate_lines(data: Data) -> list[str]:
    failed = [c for c in data["campaigns"] if c["label"] in data["failed"]]
    lines = [f"{c['label']}: {_why(c)}" for c in failed]
    hows = [c["how_words"] for c in data["campaigns"] if c["label"] not in data["failed"]]
    counted = ", ".join(f"{hows.count(how)} {how}" for how in dict.fromkeys(hows))
    return _shorten_list(lines) + ([f"{counted}."] if counted else [])


def _why(c: Data) -> str:
    """Return why a campaign has no usable estimate."""
    return str(c["reason"]) if c["grade"] is None or not c["grade"].isalpha() else f"grade {c['grade']}: {c['reason']}"


def _difference_lines(data: Data) -> list[str]:
    tested = [p for p in data["parameters"] if p["mean"] is not None]
    if not tested:
        return ["Too few units to say: two with an estimate of the same parameter are needed."]
    found = sorted((p for p in tested if p["differs"]), key=lambda p: -_share(p))
    lines = [f"{p['name']}: {_spread_words(p)}" for p in found]
    rest = [p["name"] for p in tested if not p["differs"]]
    return [*_shorten_list(lines), *([f"No more than their errors: {list_names(rest)}."] if rest else [])]


def _share(p: Data) -> float:
    return float(p["spread"] / abs(p["mean"])) if p["unit"] != "deg" and p["mean"] else 0.0


def _spread_words(p: Data) -> str:
    unit = "" if p["unit"] == "1" else f" {p['unit']}"
    mean, _ = with_sigma(p["mean"], p["std_error"])
    share = f", {digits(100.0 * _share(p), 2)} % of the mean {mean}" if _share(p) else f", mean {mean}"
    return f"spread {plain(p['spread'], 2)}{unit}{share}"


def _outlier_lines(data: Data) -> list[str]:
    lines = [
        f"{one['unit']}: {p['name']} {plain(one['value'], 4)}, {one['off']:+.1f} spreads from the others"
        for p in data["parameters"]
        for one in p["outliers"]
    ]
    return _shorten_list(lines) or ["None, in no parameter."]


def _trend_lines(data: Data) -> list[str]:
    trends = sorted((t for t in data["trends"] if t["found"]), key=lambda t: t["p_value"])
    lines = [f"{t['name']}: {_slope_words(t)}" for t in trends]
    groups = sorted((g for g in data["groups"] if g["found"]), key=lambda g: g["p_value"])
    lines += [f"{g['name']}: " + ", ".join(f"{m['group']} {plain(m['mean'], 4)}" for m in g["means"]) for g in groups]
    return _shorten_list(lines) or ["Nothing that is more than chance."]


def _slope_words(t: Data) -> str:
    slope, error = with_sigma(t["slope"], t["error"])
    share = f" ({digits(100.0 * t['slope'] / abs(t['level']), 2)} %)" if t["level"] else ""
    return f"{slope} ± {error}{share} for each {'day' if t['first_day'] else t['covariate']}"


def _change_lines(data: Data) -> list[str]:
    means = sorted((c for c in data["mean_changes"] if c["found"]), key=lambda c: c["p_value"])
    lines = [f"{c['name']}: {_mean_words(c)}" for c in means]
    own = sorted((c for c in data["changes"] if c["found"]), key=lambda c: c["p_value"])
    lines += [f"{c['unit']}: {c['name']} {plain(c['difference'], 3)}, {_sigmas(c)}" for c in own]
    return _shorten_list(lines) or ["Nothing that is more than chance."]


def _mean_words(c: Data) -> str:
    mean, error = with_sigma(c["mean"], c["error"])
    return f"{mean} ± {error} from {c['states'][0]} to {c['states'][1]}, mean of {c['units']} units"


def _sigmas(c: Data) -> str:
    return f"{c['difference'] / c['error']:+.1f} of its errors"


def _shorten_list(lines: Sequence[str]) -> list[str]:
    """Return the first lines, and the number of further ones."""
    more = [f"... and {len(lines) - SHOWN} more, in the tables."] if len(lines) > SHOWN else []
    return [*lines[:SHOWN], *more]


def list_names(names: Sequence[str]) -> str:
    """Return names in a row, those beyond eight as their number.

    Examples
    --------
    >>> list_names(["a", "b"]), list_names(list("abcdefghij"))
    ('a, b', 'a, b, c, d, e, f, g, h and 2 more')
    """
    more = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    return ", ".join(names[:SHOWN]) + more
