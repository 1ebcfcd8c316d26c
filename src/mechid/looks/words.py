"""Sentences on a record and its channels: drive, health, noise, lines, mains, resonances."""

from __future__ import annotations

from collections.abc import Sequence

from mechid.ink.data import Data
from mechid.ink.digits import digits, plain, with_sigma

SHOWN_LINES = 3
QUARTER_WORDS = {0.25: "¼", 0.5: "½", 0.75: "¾"}
NO_RATE = "The step rate is not known: a hump may also be a line that wanders."
DIFFERS = 5.0
"""Number of standard errors above which a rate differs from the declared one."""


def unit_text(unit: str) -> str:
    """Return a unit as written in a sentence.

    Examples
    --------
    >>> unit_text("N*m")
    'N m'
    """
    return unit.replace("*", " ")


def with_unit(value: float | None, count: int, unit: str) -> str:
    """Return a number with its unit, if any."""
    return f"{digits(value, count)} {unit}".rstrip()


def order_name(order: float | None) -> str:
    """Return the order of a line, its multiple of the step rate, in words.

    Examples
    --------
    >>> order_name(0.5), order_name(2.25), order_name(None)
    ('order ½', 'order 2¼', '')
    """
    if order is None:
        return ""
    whole, part = int(order), order - int(order)
    return f"order {whole or ''}{QUARTER_WORDS.get(part, '')}" if order else ""


def mains_word(line: Data) -> str:
    """Return a line's multiple of the mains' frequency in words; empty if it is none."""
    if line["mains_hz"] is None:
        return ""
    times = f" x {line['mains_multiple']}" if line["mains_multiple"] > 1 else ""
    return f"mains {line['mains_hz']:g} Hz{times}"


def resonance_word(found: Data) -> str:
    """Return a resonance with its evidence."""
    orders = ", ".join(order_name(order).removeprefix("order ") for order in found["orders"])
    tracked = f"orders {orders} of the step rate are largest there, each at its own rate" if orders else ""
    hump = "a hump of the spectrum" if found["hump"] else ""
    spread = f" ± {digits(found['spread_hz'], 2)}" if found["spread_hz"] > 0.0 else ""
    return f"{digits(found['frequency_hz'], 3)}{spread} Hz: {'; '.join(filter(None, (tracked, hump)))}"


def driven_words(driven: Data) -> list[str]:
    """Return sentences on the declared drive of a record and on the drive that its data suggest."""
    declared, suggested = driven["declared"], driven["suggested"]
    lines = [f"Declared: {declared['words']}."] if declared else []
    if suggested is None:
        return [
            *lines,
            "The record suggests no step rate: its lines have no common fundamental, no ridge runs over time.",
        ]
    if len(suggested["rates"]) > 1:
        return [*lines, _sweep_words(suggested), *_compare_ridge(declared, suggested)]
    return [*lines, *(_compare_with_declared(driven) if declared else _constant_words(suggested))]


def _sweep_words(suggested: Data) -> str:
    first, last = (digits(rate, 3) for rate in suggested["rates"])
    share = 100.0 * suggested["share"]
    return (
        f"The record suggests a rate from {first} to {last} full steps/s: this ridge stands out in {share:.0f} % of "
        "its windows. If the ridge is once every two full steps, the rate is twice that."
    )


def _compare_ridge(declared: Data | None, suggested: Data) -> list[str]:
    """Return a sentence that compares the largest declared rate with that of the ridge."""
    if declared is None:
        return []
    most, seen = (max(abs(rate) for rate in one["rates"]) for one in (declared, suggested))
    for times, words in (
        (1.0, "the rate"),
        (0.5, "half the rate"),
        (2.0, "twice the rate"),
        (4.0, "four times the rate"),
    ):
        # A ridge may be a harmonic or a subharmonic of the step rate: a repetition every one, two or four full steps.
        if abs(seen / (times * most) - 1.0) < 0.05:
            return [f"That is {words} declared."]
    return ["That is not the rate declared, nor half or twice of it: check the profile, or the time it starts."]


def _constant_words(suggested: Data) -> list[str]:
    value, sigma = with_sigma(suggested["rates"][0], suggested["sigma"])
    rate = f"{value} ± {sigma}"
    stepping = {
        "full": f"full steps at {rate} /s (half steps at half that rate look the same)",
        "micro": f"{suggested['microsteps']} microsteps a full step, at {rate} full steps/s",
        "": f"{rate} full steps/s, if what repeats is the steps",
    }[suggested["stepping"]]
    repetition = digits(suggested["repetition_hz"], 5)
    words = f"The record repeats itself at {repetition} Hz, which suggests {stepping}."
    others = " or ".join(f"{digits(rate, 4)}" for rate in suggested["others"])
    return [words, f"{others} full steps/s would explain the same lines."] if others else [words]


def _compare_with_declared(driven: Data) -> list[str]:
    """Return sentences that compare the rate of a record with the declared rate."""
    reading, declared, suggested = driven["reading"], driven["declared"], driven["suggested"]
    rates = {abs(rate) for rate in declared["rates"]}
    if reading is None:
        fits = "its lines do not fit the rate declared" if len(rates) == 1 else "but a varying rate is declared"
        return [*_constant_words(suggested), f"This contradicts the command: {fits}. Check the rate, or the record."]
    value, sigma = with_sigma(reading["rate"], reading["sigma"])
    off = reading["rate"] / rates.pop() - 1.0
    relative = reading["sigma"] / reading["rate"]
    apart = abs(off) > DIFFERS * relative
    verdict = f"{off:+.1e} of it off, more than its error: check clock and rate" if apart else "as declared"
    repeats = {1.0: "every full step", 2.0: "every two full steps", 4.0: "every four full steps"}
    every = repeats.get(reading["repeats"], f"every {reading['repeats']:g} full steps")
    lines = [f"The record itself: {value} ± {sigma} full steps/s, {verdict}; it repeats itself {every}."]
    seen, wanted = suggested["microsteps"], declared["microsteps"]
    # Two microsteps a full step are half steps, which look like full steps at another rate.
    if suggested["stepping"] == "full" and wanted > 2 and reading["repeats"] >= 1.0:
        lines.append("Its spectrum is that of full or half steps, not of microsteps as declared: check the stepping.")
    elif suggested["stepping"] == "micro" and seen is not None:
        lines.append(_microstep_words(seen * suggested["rates"][0] / reading["rate"], wanted))
    return lines


def _microstep_words(seen: float, wanted: int) -> str:
    same = abs(seen / wanted - 1.0) < 0.01
    return f"It shows {seen:g} microsteps a full step, {'as' if same else 'not'} the {wanted} declared."


def channel_words(channel: Data, *, rate_known: bool) -> dict[str, list[str]]:
    """Return sentences on a channel, by topic."""
    resonances = [one["words"] for one in channel["resonances"]]
    return {
        "health": _health(channel),
        "noise": _noise(channel),
        "lines": _lines(channel),
        "mains": _mains(channel),
        "resonances": [*resonances, *([] if rate_known else [NO_RATE])] if resonances else ["None seen."],
    }


def _health(channel: Data) -> list[str]:
    unit, gaps, clipped, spikes = channel["unit"], channel["gaps"], channel["clipped"], channel["spikes"]
    lines = []
    if gaps["count"]:
        lines.append(
            f"{_count(gaps['count'], 'gap')}, {gaps['samples']} samples missing and bridged by straight lines; "
            f"the longest {digits(gaps['longest_s'], 2)} s, the first at {_times(gaps)}."
        )
    if clipped["count"]:
        lines.append(
            f"Stays at its extreme {_count(clipped['count'], 'time')}, {digits(clipped['longest_s'], 2)} s at most, "
            f"first at {_times(clipped)}: clipped?"
        )
    if spikes["count"]:
        lines.append(f"{_count(spikes['count'], 'single sample')} far off the neighbours, first at {_times(spikes)}.")
    low, high, rms = (with_unit(channel[key], 3, unit) for key in ("min", "max", "rms"))
    return [*(lines or ["No gaps, no clipping, no spikes."]), f"{low} to {high}, RMS about the mean {rms}."]


def _count(number: int, word: str) -> str:
    return f"{number} {word}{'s' * (number != 1)}"


def _times(found: Data) -> str:
    return f"{plain(found['first_at_s'][0], 6)} s"


def _noise(channel: Data) -> list[str]:
    noise, unit = channel["noise"], channel["unit"]
    sigma, floor = (with_unit(noise[key], 3, unit) for key in ("sigma", "floor"))
    rests = {
        "floor": "from the quietest part of the upper band; coloured noise is more than that",
        "quiet stretch": f"from the quietest stretches; the white part is {floor}, the rest colour or a weak signal",
        "resolution": f"that of the resolution: the upper band holds less, {floor}",
    }[noise["rests_on"]]
    lines = [f"{sigma} a sample, {rests}."]
    if noise["quiet_rms"] is not None and noise["rests_on"] != "quiet stretch":
        lines.append(f"The quietest stretches have {with_unit(noise['quiet_rms'], 3, unit)} RMS.")
    if noise["resolution"]:
        lines.append(f"Resolution {with_unit(noise['resolution'], 3, unit)}.")
    if channel["quiet"]:
        stretches = ", ".join(f"{plain(q['from_s'], 4)} to {plain(q['to_s'], 4)} s" for q in channel["quiet"])
        lines.append(f"Quiet: {stretches}.")
    return lines


def _lines(channel: Data) -> list[str]:
    largest = sorted(channel["lines"], key=lambda line: -line["amplitude"])[:SHOWN_LINES]
    if not largest:
        return ["No line stands out of the spectrum."]
    shown = [_line(line, channel["unit"]) for line in largest]
    return [f"{_count(len(channel['lines']), 'line')}; the largest: {'; '.join(shown)}."]


def _line(line: Data, unit: str) -> str:
    text = line["text"]
    what = f" ({text['what']})" if text["what"] else ""
    return f"{text['frequency_hz']} Hz{what} {text['amplitude']} ± {text['sigma']} {unit}".rstrip()


def _mains(channel: Data) -> list[str]:
    own = [line for line in channel["mains"] if line["order"] is None]
    shared = [line for line in channel["mains"] if line["order"] is not None]
    lines = [
        f"{mains_word(line)}: {line['text']['amplitude']} ± {line['text']['sigma']} {channel['unit']}".rstrip()
        for line in own
    ]
    if shared:
        names = ", ".join(f"{mains_word(line)} and {order_name(line['order'])}" for line in _first_lines(shared))
        lines.append(f"Cannot be separated here: {names}.")
    return lines or ["No line at multiples of 50 or 60 Hz."]


def _first_lines(lines: Sequence[Data]) -> Sequence[Data]:
    return lines[:SHOWN_LINES]
