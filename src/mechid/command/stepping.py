"""The command of one record: how the stepper is stepped, how fast, and from which angle."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.command.edges import AT_ONCE, on_ticks, step_edges
from mechid.command.entry import angle_deg, chosen, is_table, is_whole, number, quoted, refuse_unknown, shown
from mechid.command.excitation import Excitation, most_within
from mechid.command.rate import RateProfile
from mechid.command.rate_entry import RATE_KEYS, rate_of
from mechid.command.waveform import WAVEFORMS, Waveform, phase_voltages
from mechid.errors import InputFileError, UsageError

Stepping: TypeAlias = Literal["full", "half", "micro"]
Start: TypeAlias = Literal["commanded", "equilibrium", "estimated"]

STEPPINGS: tuple[Stepping, ...] = ("full", "half", "micro")
STARTS: tuple[Start, ...] = ("commanded", "equilibrium", "estimated")
FIXED_MICROSTEPS: Mapping[str, int] = {"full": 1, "half": 2}
MOST_MICROSTEPS = 2**16
KEYS = ("stepping", "microsteps", *RATE_KEYS, "start_angle_deg", "waveform", "start", "clock_tick_s")


@dataclass(frozen=True, kw_only=True)
class Command:
    """Open-loop voltage stepping of a two-phase stepper ([Kornienko2013]_, VST).

    Parameters
    ----------
    stepping : {"full", "half", "micro"}
        Mode of the driver.
    microsteps : int
        Steps per full step n: 1 in full stepping, 2 in half stepping.
    rate : RateProfile
        Commanded rate in full steps/s.
    start_angle_deg : float
        Electrical angle theta_0 in degrees that the coils hold until the first step.
    waveform : {"cosine", "square"}
        Phase voltages over the electrical angle.
    start : {"commanded", "equilibrium", "estimated"}
        Whether the rotor starts at rest at the commanded angle, at the nearest equilibrium, or in a state that is found
        from the record.
    clock_tick_s : float
        Period in s of the driver's step clock, which ticks at command time 0: a step comes at the first tick at or
        after its instant, and of several due at one tick the last holds. 0 for steps at their own instants.
    begun_s : float
        Command time from which a run follows it; what was before is not simulated.

    Raises
    ------
    UsageError
        If an entry cannot be; the message starts with its name.

    Examples
    --------
    >>> command = Command(stepping="half", microsteps=2, rate=RateProfile.constant(10.0))
    >>> command.excitation(0.12).times
    array([0.05, 0.1 ])
    """

    stepping: Stepping
    microsteps: int
    rate: RateProfile
    start_angle_deg: float = 0.0
    waveform: Waveform = "cosine"
    start: Start = "commanded"
    clock_tick_s: float = 0.0
    begun_s: float = 0.0

    def __post_init__(self) -> None:
        chosen("stepping", self.stepping, STEPPINGS)
        _check_microsteps(self.microsteps, self.stepping)
        angle_deg("start_angle_deg", self.start_angle_deg)
        chosen("waveform", self.waveform, WAVEFORMS)
        chosen("start", self.start, STARTS)
        if number("clock_tick_s", self.clock_tick_s) < 0.0:
            raise UsageError(f"clock_tick_s: found {self.clock_tick_s}; write a period in s, or 0 for none")

    @classmethod
    def from_table(cls, table: Mapping[str, Any], where: str, folder: Path) -> Command:
        """Return the command that a campaign's ``command`` table describes.

        Parameters
        ----------
        table : Mapping
            The table as read from TOML.
        where : str
            File and place of the table, as ``campaign.toml: record[0].command``.
        folder : Path
            Folder against which a relative ``rate_table`` is taken.

        Raises
        ------
        InputFileError
            If an entry is unknown, missing or wrong.
        """
        if not is_table(table):
            remedy = 'write a table, as { stepping = "full", rate = 46.0 }'
            raise InputFileError(f"{where}: found {shown(table)}; {remedy}")
        try:
            return cls.from_entries(table, folder)
        except UsageError as error:
            raise InputFileError(f"{where}.{error}") from error

    @classmethod
    def from_entries(cls, table: Mapping[str, Any], folder: Path = Path()) -> Command:
        """Return the command of a ``command`` table's entries; the message of its UsageError starts with the key."""
        refuse_unknown(table, KEYS)
        if "stepping" not in table:
            raise UsageError(f"stepping: missing; write one of {quoted(STEPPINGS)}")
        stepping = chosen("stepping", table["stepping"], STEPPINGS)
        if "microsteps" not in table and stepping not in FIXED_MICROSTEPS:
            raise UsageError("microsteps: missing; micro stepping needs it, as microsteps = 16")
        return cls(
            stepping=stepping,
            microsteps=table.get("microsteps", FIXED_MICROSTEPS.get(stepping)),
            rate=rate_of(table, folder),
            start_angle_deg=angle_deg("start_angle_deg", table.get("start_angle_deg", 0.0)),
            waveform=table.get("waveform", "cosine"),
            start=table.get("start", "commanded"),
            clock_tick_s=number("clock_tick_s", table.get("clock_tick_s", 0.0)),
        )

    @property
    def steps_per_full_step(self) -> int:
        """n: steps of the index in one full step."""
        return self.microsteps

    @property
    def start_angle_rad(self) -> float:
        """Electrical angle in rad that is commanded where a run begins: theta_0 and the steps until then."""
        return math.radians(self.start_angle_deg) + 0.5 * math.pi * self._begun_index / self.microsteps

    @property
    def start_rate(self) -> float:
        """Commanded rate where a run begins, full steps/s; 0 where the command begins."""
        return self.rate.at(self.begun_s) if self.begun_s > 0.0 else 0.0

    @property
    def origin_s(self) -> float:
        """Record time in s from which a run's time counts, before any time offset."""
        return self.begun_s

    def begun_at(self, begun_s: float) -> Command:
        """Return the command as a run follows it from some command time on, which is not before it begins."""
        return replace(self, begun_s=max(begun_s, 0.0))

    @cached_property
    def _begun_index(self) -> int:
        """Index of the step that is held where a run begins."""
        _, index = self._edges(self.begun_s)
        return int(index[-1]) if index.size else 0

    def excitation(self, duration_s: float) -> Excitation:
        """Return the phase voltages over a run's time, from 0 to a duration in s.

        Raises
        ------
        UsageError
            If the duration is negative or not finite, or there are too many steps to hold.
        """
        times, index = self._edges(self.begun_s + _checked_duration(duration_s))
        if self.begun_s:
            later = times > self.begun_s
            times, index = times[later] - self.begun_s, index[later]
        values = np.empty((index.size, 2))
        for first in range(0, index.size, AT_ONCE):
            part = slice(first, first + AT_ONCE)
            values[part] = phase_voltages(index[part], self.microsteps, self.start_angle_deg, self.waveform)
        start = np.array([self._begun_index])
        initial = phase_voltages(start, self.microsteps, self.start_angle_deg, self.waveform)[0]
        return Excitation(initial=initial, times=times, values=values)

    def max_edges_per_sample(self, h: float, duration_s: float) -> int:
        """Return the greatest number of edges in any interval of one sample.

        Parameters
        ----------
        h : float
            Sample interval in s; where the samples lie does not matter, as a time offset moves them.
        duration_s : float
            Length of the record in s.
        """
        times, _ = self._edges(duration_s)
        return most_within(times, h)

    def _edges(self, duration_s: float) -> tuple[FloatArray, IntArray]:
        """Return the instants of the edges and the step index from each on, at the step clock's ticks."""
        times, index = step_edges(self.rate, self.microsteps, _checked_duration(duration_s))
        return on_ticks(times, index, self.clock_tick_s, duration_s) if self.clock_tick_s else (times, index)


def _checked_duration(duration_s: float) -> float:
    """Return a duration in s that can be, or raise `UsageError`."""
    if number("duration_s", duration_s) < 0.0:
        raise UsageError(f"duration_s: found {duration_s}; write a time of 0 s or more")
    return float(duration_s)


def stepping_of(microsteps: int) -> Stepping:
    """Return what a stepping of so many steps a full step is called."""
    return next((s for s in STEPPINGS if FIXED_MICROSTEPS.get(s) == microsteps), "micro")


def _check_microsteps(found: Any, stepping: Stepping) -> None:
    """Refuse a number of steps per full step that cannot be, or not in this stepping."""
    if not is_whole(found, 1, MOST_MICROSTEPS):
        raise UsageError(f"microsteps: found {shown(found)}; write an integer from 1 to {MOST_MICROSTEPS}")
    fixed = FIXED_MICROSTEPS.get(stepping, found)
    if found != fixed:
        remedy = f'{stepping} stepping has {fixed}: leave it out, or write stepping = "micro"'
        raise UsageError(f"microsteps: found {found}; {remedy}")
