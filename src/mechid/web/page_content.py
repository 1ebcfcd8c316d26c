"""Content of the page as a plain dict, with all numbers formatted for display."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from mechid.analysis.hypothesis import LEFT_OUT
from mechid.analysis.noise_floor_test import NoiseLevel
from mechid.campaign import Campaign
from mechid.ink.digits import digits, plain, with_sigma
from mechid.parameter import Parameter
from mechid.reports.noise import level_words
from mechid.reports.payload import order_word
from mechid.web.estimate import Estimate
from mechid.web.fit_content import run_data
from mechid.web.knobs import FINE_SIGMAS, NOTCHES, Knob
from mechid.web.picture import Effect, Picture, Scene
from mechid.web.session import Session
from mechid.web.sweep import SweepPicture

VALUE_DIGITS, MOST_DIGITS = 5, 9
ROUNDING = 1e-12
"""Relative tolerance for equal values."""
LEAST_AWAY, MOST_AWAY = 0.05, 1e3
"""Limits of displayed distances in standard errors: smaller ones are not shown, larger ones use powers of ten."""
GREEK = {
    "alpha": "α",
    "omega": "ω",
    "phi": "φ",
    "theta": "θ",
    "zeta": "ζ",
    "beta": "β",
    "delta": "δ",
    "sigma": "σ",
    "tau": "τ",
    "mu": "μ",
    "eta": "η",
    "gamma": "γ",
}
GRADES = {NoiseLevel.NOISE: "good", NoiseLevel.LOST: "bad"}
Data = dict[str, Any]


def page_data(campaign: Campaign, knobs: Mapping[str, Knob], scenes: Mapping[str, Scene]) -> Data:
    """Return the constant content of the page: title, knobs by table, records, values without a knob."""
    return {
        "title": campaign.path.resolve().parent.name or campaign.path.name,
        "path": str(campaign.path),
        "mechanism": campaign.mechanism_path.name,
        "groups": _groups(knobs),
        "notches": NOTCHES,
        "records": [_scene_entry(scene) for scene in scenes.values()],
        "fixed": [
            _fixed_entry(q, campaign.mechanism.value(q.name))
            for q in campaign.mechanism.parameters.values()
            if q.name not in knobs
        ],
        "warnings": list(campaign.warnings),
    }


def _fixed_entry(q: Parameter, value: float) -> Data:
    return {
        "name": q.name,
        "symbol": symbol_parts(q.declaration.symbol),
        "text": plain(value),
        "unit": _unit(q.declaration.unit),
        "why": f"follows {q.tied_to}" if q.tied_to else "shapes the equations",
        "meaning": q.declaration.meaning,
    }


def _groups(knobs: Mapping[str, Knob]) -> list[Data]:
    groups: dict[str, list[Data]] = {}
    for knob in knobs.values():
        table, _, key = knob.name.rpartition(".")
        groups.setdefault(table, []).append(_knob_entry(knob, key))
    return [{"table": table, "knobs": entries} for table, entries in groups.items()]


def _knob_entry(knob: Knob, key: str) -> Data:
    q = knob.parameter
    unit = _unit(q.declaration.unit)
    ends = f"{plain(q.min, 4)} to {plain(q.max, 4)} {unit}".rstrip()
    whose = "bounds of the file" if knob.is_bounded else "the file gives no bounds: a range around its value"
    return {
        "name": knob.name,
        "key": key,
        "symbol": symbol_parts(q.declaration.symbol),
        "unit": unit,
        "meaning": q.declaration.meaning,
        "low": q.min,
        "high": q.max,
        "low_text": plain(q.min, 4),
        "high_text": plain(q.max, 4),
        "log": knob.is_log,
        "hover": f"{q.declaration.symbol}: {q.declaration.meaning}. {ends} ({whose}"
        f"{', logarithmic' if knob.is_log else ''}). Source: {q.declaration.source}",
    }


def symbol_parts(symbol: str) -> tuple[str, str]:
    """Split a symbol into its letter and index, with Greek letters converted.

    Examples
    --------
    >>> symbol_parts("phi_1"), symbol_parts("K_D1"), symbol_parts("zeta")
    (('φ', '1'), ('K', 'D1'), ('ζ', ''))
    """
    head, _, index = symbol.partition("_")
    return GREEK.get(head, head), index


def _unit(unit: str) -> str:
    return "" if unit == "1" else "°" if unit == "deg" else unit.replace("*", " ")


def _scene_entry(scene: Scene) -> Data:
    record = scene.record
    assert record.data is not None
    return {
        "name": scene.label,
        "use": "validate" if "validate" in (scene.record.use, scene.match.use) else "estimate",
        "duration": f"{plain(record.data.duration_s, 3)} s",
        "file": str(record.file or ""),
        "column": record.data.channel(scene.match.quantity).column,
    }


def shown_data(
    session: Session,
    pictures: Mapping[str, Picture],
    effects: Mapping[str, Effect],
    sweeps: Mapping[str, SweepPicture],
) -> Data:
    """Return the content of the page for the current state of the session."""
    return {
        "knobs": {name: _knob_now(session, knob) for name, knob in session.state.knobs.items()},
        "records": [_panel(name, picture, effects.get(name), session) for name, picture in pictures.items()],
        "sweeps": [
            {"name": name, "words": _sweep_words(sweep), "tops_hz": sweep.tops_hz} for name, sweep in sweeps.items()
        ],
        "uses": {name: _use_words(scene, session.estimate) for name, scene in session.scenes.items()},
        "effects": {one.name: one.is_on(session.state.now.values) for one in session.source.effects},
        "reaches_estimate": session.reaches_estimate,
        "apart": distance_words(session),
        "hand": session.hand,
        "seconds": session.seconds,
        "can_undo": bool(session.state.past),
        "compares": session.compares,
        "free": len(session.state.now.free),
        "primary": "search" if session.is_at_catalogue else "fit",
        "estimate": session.estimate.source if session.estimate else "",
        "verdict": session.estimate.summary if session.estimate else None,
        "run": run_data(session.shown_run, session.state.knobs) if session.shown_run else None,
    }


def limit_message(knob: Knob, asked: float, used: float) -> str:
    """Explain why another value than the requested one is used; empty if it is used unchanged."""
    if math.isclose(asked, used, rel_tol=ROUNDING):
        return ""
    low, high = knob.parameter.min, knob.parameter.max
    if low <= asked <= high:
        return f"{plain(asked)} would pass another parameter that limits this one; {plain(used)} is used"
    side, end = ("above", high) if asked > high else ("below", low)
    whose = "bound of the mechanism file" if knob.is_bounded else "end of this slider's range"
    return f"{plain(asked)} is {side} the {whose}; {plain(end)} is used"


def distance_words(session: Session) -> str:
    """Describe the distance of the current values from the graded estimate; empty if they are equal."""
    estimate, values = session.estimate, session.state.now.values
    if estimate is None:
        return ""
    graded = session.state.at(session.values_of(estimate)).now.values
    off = [name for name, value in values.items() if not math.isclose(value, graded[name], rel_tol=ROUNDING)]
    if not off:
        return ""
    sigmas = {name: abs(estimate.sigmas_from(name, values[name]) or 0.0) for name in off}
    most = max(off, key=lambda name: sigmas[name])
    farthest = f", {most} by {_sigmas_text(sigmas[most])}" if sigmas[most] else f", {most} among them"
    return (
        f"The grade is that of the last estimate, not of the values set below: {len(off)} "
        f"{'parameter differs' if len(off) == 1 else 'parameters differ'}{farthest}."
    )


def _sigmas_text(sigmas: float) -> str:
    return f"{sigmas:.2g} σ" if sigmas < MOST_AWAY else f"{sigmas:.0e} σ"


def _use_words(scene: Scene, estimate: Estimate | None) -> str:
    """Describe a record that is held out or was left out; empty for a fitted record."""
    if estimate and scene.record.name in estimate.left_out:
        return f"{LEFT_OUT} of the last fit"
    return "held out" if "validate" in (scene.record.use, scene.match.use) else ""


def _knob_now(session: Session, knob: Knob) -> Data:
    value = session.state.now.values[knob.name]
    estimate = session.estimate
    sigma = estimate.sigmas.get(knob.name) if estimate else None
    fine = knob.fine_step(value, sigma)
    now: Data = {
        "value": value,
        "text": plain(value, _digits_to(fine, value)),
        "fine": fine,
        "fine_text": f"{plain(fine, 2)} {_unit(knob.parameter.declaration.unit)}".rstrip()
        + (f" ({FINE_SIGMAS:g} σ)" if sigma else " (a hundredth of a notch)"),
        "place": knob.place(value),
        "free": knob.name in session.state.now.free,
        "estimate_place": None,
        "away": "",
        "estimate": "",
    }
    if estimate and knob.name in estimate.values:
        text, error = with_sigma(estimate.values[knob.name], sigma)
        away = estimate.sigmas_from(knob.name, value)
        now["estimate_place"] = knob.place(estimate.values[knob.name])
        now["estimate"] = f"{text} ± {error}" if error else text
        now["away"] = _away_text(away)
    return now


def _digits_to(step: float, value: float) -> int:
    """Return the number of digits that resolve a step of a value, usually five.

    Examples
    --------
    >>> _digits_to(0.09, 913.47), _digits_to(1e-5, 913.47)
    (5, 8)
    """
    # A step has to change the displayed number.
    needed = math.ceil(math.log10(abs(value) / step)) if step > 0.0 and abs(value) > step else 0
    return min(max(needed, VALUE_DIGITS), MOST_DIGITS)


def _away_text(away: float | None) -> str:
    if away is None or abs(away) < LEAST_AWAY:
        return ""
    return f"{away:+.1f} σ" if abs(away) < MOST_AWAY else f"{away:+.0e} σ"


def _panel(name: str, picture: Picture, effect: Effect | None, session: Session) -> Data:
    n, unit = picture.numbers, session.scenes[name].unit
    residual, ratio = n.residual, n.residual.ratio
    return {
        "name": name,
        "grade": GRADES.get(residual.level, "caution"),
        "numbers": [
            ("residual", amount(residual.residual_rms, unit)),
            ("noise floor", amount(residual.noise_sigma, unit)),
            ("residual / noise", digits(ratio, 3)),
            ("by chance up to", plain(residual.most_by_chance, 4)),
            ("fit", f"{digits(n.fit_percent, 4)} %"),
            ("offset", amount(n.offset, unit)),
            ("drift", f"{amount(n.drift, unit)}/s"),
        ],
        "ratio": None if not math.isfinite(ratio) else ratio,
        "words": level_words(residual),
        "effect": _effect_words(effect, session, unit),
    }


def amount(value: float, unit: str) -> str:
    """Format a small amount with its unit, a torque in mN m.

    Examples
    --------
    >>> amount(0.0020123, "N*m"), amount(0.5, "A")
    ('2.01 mN m', '0.500 A')
    """
    if unit == "N*m":
        return f"{digits(1e3 * value, 3)} mN m"
    return f"{digits(value, 3)} {_unit(unit)}".rstrip()


def _effect_words(effect: Effect | None, session: Session, channel_unit: str) -> str:
    if effect is None:
        return ""
    knob = session.state.knobs[session.hand]
    if effect.rms == 0.0:
        return f"{knob.name} does not act on this stretch at all."
    unit = _unit(knob.parameter.declaration.unit)
    return (
        f"{effect.words} of {knob.name} moves this stretch by {amount(effect.rms, channel_unit)} RMS; if all else "
        f"were known, the stretch would determine it to ± {digits(effect.alone, 2)} {unit}".rstrip()
        + "."
    )


def _sweep_words(sweep: SweepPicture) -> str:
    """List the marked orders and resonances."""
    orders = ", ".join(order_word(order) for order in sweep.orders)
    swinging = ", ".join(f"{r.name} {digits(r.frequency_hz, 3)} Hz" for r in sweep.resonances)
    marked = f"Marked are the orders {orders} of the step rate"
    return f"{marked} and the resonances as set: {swinging}." if swinging else f"{marked}."
