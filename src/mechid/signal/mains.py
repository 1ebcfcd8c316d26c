"""Mains hum: lines at 50 or 60 Hz and their multiples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechid.signal.lines import Line, Prominence
from mechid.signal.settings import HUM


@dataclass(frozen=True, kw_only=True)
class MainsLine:
    """Line at a multiple of the mains frequency, which is 50 or 60 Hz."""

    mains_hz: float
    multiple: int
    line: Line


def mains_lines(found: Prominence, least_ratio: float = HUM.least_ratio) -> tuple[MainsLine, ...]:
    """Return the mains lines from 20 to 1000 Hz, sorted by frequency.

    A line at a common multiple of 50 and 60 Hz is attributed to the grid with the stronger lines.

    Parameters
    ----------
    found : Prominence
        From `mechid.signal.lines.prominence`.
    """
    lines = [
        line
        for mains in HUM.mains_hz
        for line in _lines_of_one_grid(_lines_near(found, mains, least_ratio), found.bin_hz)
    ]
    strength = {mains: sum(line.line.ratio for line in lines if line.mains_hz == mains) for mains in HUM.mains_hz}
    own: dict[int, MainsLine] = {}
    # Sorted by strength: where two lines share a bin, that of the stronger grid is written last and remains.
    for line in sorted(lines, key=lambda line: strength[line.mains_hz]):
        own[round(line.line.frequency_hz / found.bin_hz)] = line
    return tuple(sorted(own.values(), key=lambda line: line.line.frequency_hz))


def _lines_of_one_grid(lines: list[MainsLine], bin_hz: float) -> list[MainsLine]:
    """Return the lines that are consistent with one mains frequency.

    The list is empty without the fundamental or two low multiples: any signal may have lines near high multiples.
    """
    low = [one for one in lines if one.multiple <= HUM.low_multiples]
    if len(low) < 2 and not any(one.multiple == 1 for one in low):
        return []
    strongest = max(low, key=lambda one: one.line.ratio)
    grid = strongest.line.frequency_hz / strongest.multiple
    apart = (abs(one.line.frequency_hz - one.multiple * grid) / one.multiple for one in lines)
    near = max(HUM.alike * grid, HUM.interpolated * bin_hz / strongest.multiple)
    return [one for one, off in zip(lines, apart, strict=True) if off <= near]


def _lines_near(found: Prominence, mains: float, least_ratio: float) -> list[MainsLine]:
    top = min(HUM.highest_hz, 0.5 * found.sample_rate_hz - 2.0 * found.bin_hz)
    ratio, lines = found.ratio, []
    for multiple in range(1, int(top / mains) + 1):
        reach = max(HUM.wander * multiple * mains, HUM.bins * found.bin_hz)
        ends = (np.array([-reach, reach]) + multiple * mains) / found.bin_hz
        first, stop = max(int(np.ceil(ends[0])), 1), min(int(ends[1]) + 1, ratio.size - 1)
        if multiple * mains < HUM.lowest_hz or stop <= first:
            continue
        at = first + int(np.argmax(ratio[first:stop]))
        peaked = found.amplitude[at] >= max(found.amplitude[at - 1], found.amplitude[at + 1])
        line = found.line_at(at)
        nearest = max(HUM.wander * multiple * mains, HUM.interpolated * found.bin_hz)
        if ratio[at] >= least_ratio and peaked and abs(line.frequency_hz - multiple * mains) <= nearest:
            lines.append(MainsLine(mains_hz=mains, multiple=multiple, line=line))
    return lines
