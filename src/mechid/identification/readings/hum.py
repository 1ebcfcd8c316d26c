"""Detector of mains hum: lines at grid frequencies that are neither orders of the step rate nor resonances."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from mechid.identification.output_error.target import Target
from mechid.identification.readings.finding import DeclaredRecords, Finding
from mechid.identification.readings.rules import RULES
from mechid.signal.lines import Prominence, prominence
from mechid.signal.mains import MainsLine, mains_lines
from mechid.signal.settings import HUM


def find_hum(records: DeclaredRecords, earlier: Sequence[Finding] = ()) -> Iterator[Finding]:
    """Yield a finding on the records with clear hum; nothing before a search, which removes hum by itself."""
    if records.before_search:
        return
    found = {target.name: line for target in records.readable if (line := _strongest_hum(target))}
    if not found:
        return
    name, strongest = max(found.items(), key=lambda item: item[1].line.amplitude)
    yield Finding(
        tuple(found),
        "mains hum",
        f"a line at {strongest.line.frequency_hz:.5g} Hz, of {strongest.line.amplitude:.2g} N m in {name}, is mains "
        "hum by its frequency",
        f"write mains = {strongest.mains_hz:g} in [identify] to have it removed from all records",
    )


def _strongest_hum(target: Target) -> MainsLine | None:
    """Return the strongest mains line if it is a low multiple; in a short record many lines are near high multiples."""
    found = prominence(target.leading.measured, target.base.sample_rate_hz)
    rates = set(map(abs, target.command.rate.rates))
    orders = [rate / RULES.order_parts for rate in rates if rate and len(rates) == 1]
    loud = [one for one in mains_lines(found) if one.line.amplitude > RULES.least_hum * target.leading.sigma]
    hum = [one for one in loud if not any(_is_order(one, order, found.bin_hz) for order in orders)]
    # Lines of a varying rate move through the spectrum: only their width distinguishes them from hum.
    if len(rates) > 1:
        hum = [one for one in hum if _is_narrow(one, found)]
    strongest = max(hum, key=lambda one: one.line.amplitude, default=None)
    return strongest if strongest and strongest.multiple <= HUM.low_multiples else None


def _is_narrow(one: MainsLine, found: Prominence) -> bool:
    """Tell whether a line is narrow; a rate that passes a resonance is as high a few bins away."""
    at = round(one.line.frequency_hz / found.bin_hz)
    beside = (found.amplitude[at + sign * bins] for sign in (-1, 1) for bins in RULES.skirt_bins)
    return bool(max(beside, default=0.0) < RULES.narrow_share * found.amplitude[at])


def _is_order(one: MainsLine, order_hz: float, bin_hz: float) -> bool:
    hz = one.line.frequency_hz
    return abs(hz - round(hz / order_hz) * order_hz) < RULES.order_bins * bin_hz
