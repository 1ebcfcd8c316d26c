"""Statement on the bench: how its loads were made, and up to which frequency they can be trusted."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from mechid.analysis.measured_resonances import measured_resonances
from mechid.campaign.table_response_entry import DeclaredResponse
from mechid.emissions.background import Background
from mechid.emissions.interface import Interface
from mechid.emissions.settings import BENCH
from mechid.ink.digits import plain
from mechid.signal.density import power_density
from mechid.signal.lines import prominence, spectral_lines
from mechid.signal.remainder import Remainder
from mechid.signal.trend import fit_line


@dataclass(frozen=True, kw_only=True)
class BenchUse:
    """What was made of the channels of a bench.

    Attributes
    ----------
    calibration, response : str
        What they come from; empty without one.
    calibration_error : float
        Relative standard error.
    point_m : (float, float, float) or None
        Point that moments are about, from the table's reference point; None without a declared bench.
    bands_hz : mapping of str to (float, float)
        Band of each direction that the bench supports; up to infinity where nothing limits it.
    trusted_hz : float
        Frequency up to which all directions can be trusted; NaN where nothing tells.
    reason : str
        Why no further.
    """

    calibration: str = ""
    response: str = ""
    calibration_error: float = 0.0
    point_m: tuple[float, float, float] | None = None
    bands_hz: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    trusted_hz: float = math.nan
    reason: str = ""

    def notes(self) -> Iterator[str]:
        """Yield what a reader has to know about the bench, a sentence each."""
        if self.calibration:
            yield (
                f"Loads are calibrated by {self.calibration}, with a standard error of "
                f"{100.0 * self.calibration_error:.2g} %."
            )
        else:
            yield "No calibration matrix is declared: loads are taken as recorded, cross-talk between them included."
        if self.point_m is not None and any(self.point_m):
            yield f"Moments are about the point at [{', '.join(plain(x, 4) for x in self.point_m)}] m of the table."
        if self.response:
            bands = ", ".join(f"{one} {plain(high, 4)} Hz" for one, (_, high) in self.bands_hz.items())
            yield f"The response of the table, {self.response}, is corrected up to: {bands}. {self.reason}"
        else:
            yield self.reason


def bench_use(interface: Interface, backgrounds: Mapping[str, Background | None], sample_rate_hz: float) -> BenchUse:
    """Return what is known of a bench.

    Parameters
    ----------
    interface : Interface
    backgrounds : mapping of str to Background or None
        By direction; resonances of a table without a declared response show in their noise.
    sample_rate_hz : float
        Of the records.
    """
    bench = interface.bench
    bands = {one: interface.band_hz(one) for one in backgrounds}
    highest = min((high for _, high in bands.values()), default=math.inf)
    if interface.is_corrected:
        trusted, reason = highest, _reason_of_correction(interface)
    elif bench.usable_band_hz:
        trusted = highest
        reason = f"No response of the table is declared; usable_band_hz trusts it up to {plain(highest, 4)} Hz."
    else:
        trusted, reason = from_resonance(
            lowest_resonance(backgrounds), sample_rate_hz, is_measured=any(backgrounds.values())
        )
    response = bench.response
    return BenchUse(
        calibration=bench.calibration.source if bench.calibration else "",
        response="" if response is None else _name(response),
        calibration_error=bench.calibration.uncertainty if bench.calibration else 0.0,
        point_m=interface.mounting.point_m if interface.mounting else None,
        bands_hz=bands,
        trusted_hz=trusted,
        reason=reason,
    )


def _name(response: DeclaredResponse) -> str:
    count = len(response.modes)
    return response.file.name if response.file else f"{count} mode{'s' * (count > 1)}"


def _reason_of_correction(interface: Interface) -> str:
    """Return why the correction ends where it does."""
    response = interface.bench.response
    assert response is not None
    end = "with the measured response" if response.file else "without a mode at a third of the highest one"
    declared = ", or usable_band_hz" if interface.bench.usable_band_hz else ""
    return (
        f"Each ends where the uncertainty of the correction itself (95 %) exceeds 1 dB, or {end}{declared}. Below, "
        "that uncertainty is part of all bounds."
    )


def from_resonance(found: tuple[str, float] | None, sample_rate_hz: float, *, is_measured: bool) -> tuple[float, str]:
    """Return up to which frequency a table without a declared response can be trusted, and why."""
    remedy = "declare table_response or usable_band_hz in [bench]"
    if found is None:
        shown = (
            f"its background shows no resonance up to {plain(0.5 * sample_rate_hz, 4)} Hz, which proves none"
            if is_measured
            else "no background was measured that could show its resonances"
        )
        return math.nan, (
            f"No response of the table is declared, and {shown}: a table adds less than 1 dB up to a third of its "
            f"first resonance, which has to be known from elsewhere; {remedy}."
        )
    direction, frequency = found
    trusted = BENCH.rigid_share * frequency
    return trusted, (
        f"No response of the table is declared. The background of {direction} shows a resonance at "
        f"{plain(frequency, 3)} Hz; the records can be trusted up to {plain(trusted, 3)} Hz, a third of it, where it "
        f"adds 1 dB to an amplitude. What is judged above rests on an uncorrected table; {remedy}."
    )


def lowest_resonance(backgrounds: Mapping[str, Background | None]) -> tuple[str, float] | None:
    """Return the direction and the frequency in Hz of the lowest resonance in the noise of backgrounds, or None."""
    found = []
    for direction, background in backgrounds.items():
        y = background.samples(direction) if background else None
        if background is None or y is None:
            continue
        rate = background.record.sample_rate_hz
        level = Remainder(y, fit_line(y, 2))
        frequency, density = power_density(level, rate)
        lines = spectral_lines(prominence(level, rate))
        for one in measured_resonances((), frequency, density, lines=lines, spacing_hz=0.0):
            found.append((one.frequency_hz, direction))
    return min(found)[::-1] if found else None
