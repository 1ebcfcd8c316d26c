"""Register layouts of drivers with a programmable wave: what they can represent of a table, and its registers.

TMC2130 and TMC5130 (Trinamic) hold one quarter of one wave as differences: 256 bits, in up to four segments, each of
which lets a bit mean a difference of W - 1 or W, W from 0 to 3. Both coils read the same wave, 90 deg apart, and its
quarters mirror one another. DRV8462 (Texas Instruments) holds eight amplitudes of one quarter at eight microsteps a
full step. Neither can hold a table whose phases differ or whose quarters do not mirror. In the direct mode of the TMC
drivers (XDIRECT) a processor writes both coils' signed 9-bit codes at each microstep, which represents any table.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np

from mechid.arrays import FloatArray, IntArray

QUARTER, AMPLITUDE = 256, 247
"""Entries of a quarter wave, and the amplitude that the data sheets recommend, below 255."""
GRID = 16
"""Spacing at which segment ends are tried."""
TMC, DRV = "TMC2130/TMC5130", "DRV8462"
DRV_MICROSTEPS, DRV_LARGEST, DRV_FIRST_REGISTER = 8, 255, 0x17


@dataclass(frozen=True, eq=False)
class QuarterWave:
    """A quarter wave in the registers of a TMC driver.

    Attributes
    ----------
    start_sin, start_sin90 : int
        Entries 0 and 256 of the wave, codes.
    bits : (256,) int
        Difference bit of each entry.
    widths : tuple of int
        W of each segment.
    ends : tuple of int
        First entries of the second to fourth segment.
    wave : (257,) int
        Decoded codes.
    """

    start_sin: int
    start_sin90: int
    bits: IntArray
    widths: tuple[int, int, int, int]
    ends: tuple[int, int, int]
    wave: IntArray

    @property
    def registers(self) -> dict[str, int]:
        """Register values by name."""
        words = self.bits.reshape(8, 32) @ (1 << np.arange(32, dtype=np.int64))
        out = {f"MSLUT{k}": int(word) for k, word in enumerate(words)}
        select = sum(width << (2 * k) for k, width in enumerate(self.widths))
        out["MSLUTSEL"] = select | sum(end << (8 * (k + 1)) for k, end in enumerate(self.ends))
        return out | {"MSLUTSTART": self.start_sin | self.start_sin90 << 16}


def encode_quarter(wanted: FloatArray) -> QuarterWave:
    """Return the encoding nearest to a quarter wave, (257,) codes, in its largest error.

    Each bit brings the decoded wave as near to the wanted one as its segment allows; all segment ends on a grid of
    `GRID` entries are tried.
    """
    best: QuarterWave | None = None
    least = np.inf
    for ends in combinations(range(GRID, QUARTER, GRID), 3):
        found = _encode(wanted, ends)
        error = float(np.max(np.abs(found.wave - wanted)))
        if error < least:
            best, least = found, error
    assert best is not None
    return best


def quarter_of_table(table: FloatArray, amplitude: int = AMPLITUDE) -> FloatArray:
    """Return phase B's first quarter, (257,) codes, between the microsteps by straight lines."""
    microsteps = len(table) // 4
    at = np.arange(QUARTER + 1) * microsteps / QUARTER
    return amplitude * np.interp(at, np.arange(microsteps + 1), table[: microsteps + 1, 1])


def table_of_quarter(wave: FloatArray, microsteps: int) -> FloatArray:
    """Return the table, (4 n, 2), that a driver plays from a quarter wave (257,), fractions of the peak."""
    at = np.arange(4 * microsteps) * QUARTER // microsteps
    return np.column_stack([-_whole_wave(wave, at + QUARTER), _whole_wave(wave, at)])


def eighth_step_codes(table: FloatArray) -> list[int]:
    """Return the eight current codes of a DRV8462, (8,), for microsteps 1 to 8 of the first quarter.

    Examples
    --------
    >>> from mechid.command.phase_table import nominal_table
    >>> eighth_step_codes(nominal_table(8))
    [50, 98, 142, 180, 212, 236, 250, 255]
    """
    quarter = np.rint(DRV_LARGEST * table[1 : DRV_MICROSTEPS + 1, 1])
    return [int(code) for code in np.clip(quarter, 0, DRV_LARGEST)]


def _whole_wave(wave: FloatArray, at: IntArray) -> FloatArray:
    turned = at % (4 * QUARTER)
    quarter, rest = turned // QUARTER, turned % QUARTER
    own = np.where(quarter % 2 == 0, wave[rest], wave[QUARTER - rest])
    return np.where(quarter < 2, own, -own)


def _encode(wanted: FloatArray, ends: tuple[int, ...]) -> QuarterWave:
    edges = (0, *ends, QUARTER)
    value = start = round(float(wanted[0]))
    bits, wave, widths = [], [start], []
    for first, stop in pairwise(edges):
        # A segment plays W - 1 and W, so that the mean slope has to lie between them.
        slope = (float(wanted[stop]) - value) / (stop - first)
        width = int(np.clip(np.ceil(slope), 0, 3))
        widths.append(width)
        for k in range(first, stop):
            bit = int(float(wanted[k + 1]) > value + width - 0.5)
            value += width - 1 + bit
            bits.append(bit)
            wave.append(value)
    a, b, c, d = widths
    x, y, z = ends
    peak = round(float(wanted[QUARTER]))
    return QuarterWave(start, peak, np.array(bits), (a, b, c, d), (x, y, z), np.array(wave))
