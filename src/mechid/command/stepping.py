"""Command of one record: stepping mode, rate profile and start angle."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.command.edges import AT_ONCE, quantise_to_ticks, step_edges
from mechid.command.entry import (
    angle_deg,
    choose_option,
    format_found,
    is_table,
    is_whole,
    number,
    quote_words,
    refuse_unknown,
)
from mechid.command.excitation import Excitation, most_within
from mechid.command.phase_table import PhaseTable, checked_table, first_row, symmetry_deg, table_of, table_voltages
from mechid.command.pulse import Pulse
from mechid.command.rate import RateProfile
from mechid.command.rate_entry import RATE_KEYS, rate_of
from mechid.command.waveform import WAVEFORMS, Waveform, phase_voltages, steps_per_period
from mechid.errors import InputFileError, UsageError

Stepping: TypeAlias = Literal["full", "half", "micro"]
Start: TypeAlias = Literal["commanded", "equilibrium", "estimated"]

STEPPINGS: tuple[Stepping, ...] = ("full", "half", "micro")
STARTS: tuple[Start, ...] = ("commanded", "equilibrium", "estimated")
FIXED_MICROSTEPS: Mapping[str, int] = {"full": 1, "half": 2}
MOST_MICROSTEPS = 2**16
KEYS = ("stepping", "microsteps", *RATE_KEYS, "start_angle_deg", "waveform", "table", "start", "clock_tick_s")


@dataclass(frozen=True, kw_only=True)
class Command:
    """Open-loop voltage stepping of a stepper ([Kornienko2013]_, VST).

    Parameters
    ----------
    stepping : {"full", "half", "micro"}
        Stepping mode of the driver.
    microsteps : int
        Steps per full step n: 1 in full stepping, 2 in half stepping.
    rate : RateProfile
        Commanded rate in full steps/s.
    start_angle_deg : float
        Electrical angle theta_0 in degrees, held until the first step.
    waveform : {"cosine", "square"}
        Phase voltages over the electrical angle.
    table : tuple of (float, float)
        Driver's table of both phases in place of the waveform, (4 n, 2), as `phase_table` has it; empty for none.
    start : {"commanded", "equilibrium", "estimated"}
        The rotor starts at rest at the commanded angle, at rest at the nearest equilibrium, or in a state estimated
        from the record.
    clock_tick_s : float
        Period in s of the driver's step clock, which ticks at command time 0: a step occurs at the first tick at or
        after its instant, and of several steps due at one tick the last one holds. 0 for steps at their own instants.
    begun_s : float
        Command time at which a run begins; earlier times are not simulated.
    phases : {2, 3, 4}
        Number of phases of the motor, as its mechanism file states it: a full step is 90 deg electrical, with three
        phases 60 deg.
    pulse : Pulse or None
        Pulses of the driver, as the mechanism file states them; None if it holds its phases from step to step.

    Raises
    ------
    UsageError
        An entry is invalid; the message starts with its name.

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
    table: PhaseTable = ()
    start: Start = "commanded"
    clock_tick_s: float = 0.0
    begun_s: float = 0.0
    phases: int = 2
    pulse: Pulse | None = None

    def __post_init__(self) -> None:
        choose_option("stepping", self.stepping, STEPPINGS)
        _check_microsteps(self.microsteps, self.stepping)
        angle_deg("start_angle_deg", self.start_angle_deg)
        choose_option("waveform", self.waveform, WAVEFORMS)
        choose_option("start", self.start, STARTS)
        self._check_table()
        if number("clock_tick_s", self.clock_tick_s) < 0.0:
            raise UsageError(f"clock_tick_s: found {self.clock_tick_s}; write a period in s, or 0 for none")

    def _check_table(self) -> None:
        """Refuse a table beside another waveform, another stepping, or a start between two of its rows."""
        if not self.table:
            return
        if self.phases == 3:
            raise UsageError("table: it has the values of two phases, the motor has 3; leave it out")
        _refuse_table(self.stepping)
        if self.waveform != "cosine":
            raise UsageError(f'table: found beside waveform = "{self.waveform}"; keep one of them')
        object.__setattr__(self, "table", checked_table(self.table, self.microsteps))
        first_row(self.start_angle_deg, self.microsteps)

    @classmethod
    def from_table(cls, table: Mapping[str, Any], where: str, folder: Path) -> Command:
        """Return the command that a campaign's ``command`` table describes.

        Parameters
        ----------
        table : Mapping
            The table as read from TOML.
        where : str
            File and position of the table, as ``campaign.toml: record[0].command``.
        folder : Path
            Folder to which a relative ``rate_table`` refers.

        Raises
        ------
        InputFileError
            If an entry is unknown, missing or wrong.
        """
        if not is_table(table):
            remedy = 'write a table, as { stepping = "full", rate = 46.0 }'
            raise InputFileError(f"{where}: found {format_found(table)}; {remedy}")
        try:
            return cls.from_entries(table, folder)
        except UsageError as error:
            raise InputFileError(f"{where}.{error}") from error

    @classmethod
    def from_entries(cls, table: Mapping[str, Any], folder: Path = Path()) -> Command:
        """Return the command of the entries of a ``command`` table; the message of a UsageError starts with the key."""
        refuse_unknown(table, KEYS)
        if "stepping" not in table:
            raise UsageError(f"stepping: missing; write one of {quote_words(STEPPINGS)}")
        stepping = choose_option("stepping", table["stepping"], STEPPINGS)
        if "microsteps" not in table and stepping not in FIXED_MICROSTEPS:
            raise UsageError("microsteps: missing; micro stepping needs it, as microsteps = 16")
        microsteps = table.get("microsteps", FIXED_MICROSTEPS.get(stepping))
        _check_microsteps(microsteps, stepping)
        return cls(
            stepping=stepping,
            microsteps=microsteps,
            rate=rate_of(table, folder, microsteps),
            start_angle_deg=angle_deg("start_angle_deg", table.get("start_angle_deg", 0.0)),
            waveform=table.get("waveform", "cosine"),
            table=_table_of(table, stepping, microsteps, folder),
            start=table.get("start", "commanded"),
            clock_tick_s=number("clock_tick_s", table.get("clock_tick_s", 0.0)),
        )

    @property
    def steps_per_full_step(self) -> int:
        """Steps of the index in one full step, n."""
        return self.microsteps

    @property
    def waveform_name(self) -> str:
        """What sets the phases at a microstep: the waveform, or "table"."""
        return "table" if self.table else self.waveform

    @property
    def symmetry_deg(self) -> float:
        """Electrical angle by which the start may turn along the waveform, a full step, or more along a table."""
        return symmetry_deg(self.table) if self.table else self.full_step_deg

    @property
    def full_steps(self) -> int:
        """Full steps in an electrical period."""
        return steps_per_period(self.phases)

    @property
    def full_step_deg(self) -> float:
        """Electrical angle of a full step: 90 deg, or 60 deg with three phases."""
        return 360.0 / self.full_steps

    @property
    def mirrored_steps(self) -> int:
        """Full steps after which the voltages change sign: half a period, or a whole one if a table lacks this."""
        return self.full_steps if self.symmetry_deg > 180.0 else self.full_steps // 2

    @property
    def start_angle_rad(self) -> float:
        """Electrical angle in rad commanded at the start of a run: theta_0 plus the steps until then."""
        step = math.radians(self.full_step_deg)
        return math.radians(self.start_angle_deg) + step * self._first_index / self.microsteps

    @property
    def start_rate(self) -> float:
        """Commanded rate at the start of a run, full steps/s; 0 if it starts with the command."""
        return self.rate.at(self.begun_s) if self.begun_s > 0.0 else 0.0

    @property
    def origin_s(self) -> float:
        """Record time in s at which a run's time is zero, without any time offset."""
        return self.begun_s

    def begin_at(self, begun_s: float) -> Command:
        """Return the command for a run that begins at a command time, which is clipped to 0 from below."""
        return replace(self, begun_s=max(begun_s, 0.0))

    def for_motor(self, phases: int, pulse: Pulse | None = None) -> Command:
        """Return the command for a motor with a number of phases and the pulses of its driver.

        Raises
        ------
        UsageError
            It follows a table of two phases and the motor has three, or a step is shorter than a pulse.
        """
        if pulse:
            pulse.check(self.microsteps * max(map(abs, self.rate.rates)))
        return self if (phases, pulse) == (self.phases, self.pulse) else replace(self, phases=phases, pulse=pulse)

    @cached_property
    def _first_index(self) -> int:
        """Step index held at the start of a run."""
        _, index = self._edges(self.begun_s)
        return int(index[-1]) if index.size else 0

    def excitation(self, duration_s: float) -> Excitation:
        """Return the phase voltages over a run's time, from 0 to a duration in s.

        Raises
        ------
        UsageError
            The duration is negative or not finite, or there are too many steps.
        """
        times, index = self._edges(self.begun_s + _check_duration(duration_s))
        last_s = -math.inf
        if self.begun_s:
            later = times > self.begun_s
            last_s = float(np.max(times[~later], initial=-math.inf)) - self.begun_s
            times, index = times[later] - self.begun_s, index[later]
        values = np.empty((index.size, 2))
        # In chunks: the temporaries of millions of edges would take several times the memory of the result.
        for first in range(0, index.size, AT_ONCE):
            part = slice(first, first + AT_ONCE)
            values[part] = self._voltages(index[part])
        initial = self._voltages(np.array([self._first_index]))[0]
        whole = Excitation(initial=initial, times=times, values=values)
        return self.pulse.cut(whole, last_s, duration_s) if self.pulse else whole

    def _voltages(self, index: IntArray) -> FloatArray:
        """Return e_A and e_B of step indices, (E, 2)."""
        if self.table:
            return table_voltages(self.table, index, self.start_angle_deg, self.microsteps)
        return phase_voltages(index, self.microsteps, self.start_angle_deg, self.waveform, self.phases)

    def max_edges_per_sample(self, h: float, duration_s: float) -> int:
        """Return the largest number of edges in any interval of one sample.

        Parameters
        ----------
        h : float
            Sample interval in s; the result holds for any position of the samples, since a time offset shifts them.
        duration_s : float
            Length of the record in s.
        """
        times = self.excitation(duration_s).times if self.pulse else self._edges(duration_s)[0]
        return most_within(times, h)

    def _edges(self, duration_s: float) -> tuple[FloatArray, IntArray]:
        """Return the instants of the edges, on a step clock's ticks if there is one, and the index from each on."""
        times, index = step_edges(self.rate, self.microsteps, _check_duration(duration_s))
        return quantise_to_ticks(times, index, self.clock_tick_s, duration_s) if self.clock_tick_s else (times, index)


def _table_of(table: Mapping[str, Any], stepping: Stepping, microsteps: int, folder: Path) -> PhaseTable:
    """Return the driver's table that a ``command`` table gives, if any."""
    if "table" not in table:
        return ()
    _refuse_table(stepping)
    return table_of(table["table"], microsteps, folder)


def _refuse_table(stepping: Stepping) -> None:
    """Refuse a table in another stepping than microsteps."""
    if stepping != "micro":
        raise UsageError(f"table: found with {stepping} stepping; only micro stepping follows a table")


def _check_duration(duration_s: float) -> float:
    """Return a valid duration in s, or raise `UsageError`."""
    if number("duration_s", duration_s) < 0.0:
        raise UsageError(f"duration_s: found {duration_s}; write a time of 0 s or more")
    return float(duration_s)


def stepping_of(microsteps: int) -> Stepping:
    """Return the stepping mode with the given number of steps per full step."""
    return next((s for s in STEPPINGS if FIXED_MICROSTEPS.get(s) == microsteps), "micro")


def _check_microsteps(found: Any, stepping: Stepping) -> None:
    """Refuse a number of steps per full step that is invalid in the stepping mode."""
    if not is_whole(found, 1, MOST_MICROSTEPS):
        raise UsageError(f"microsteps: found {format_found(found)}; write an integer from 1 to {MOST_MICROSTEPS}")
    fixed = FIXED_MICROSTEPS.get(stepping, found)
    if found != fixed:
        remedy = f'{stepping} stepping has {fixed}: leave it out, or write stepping = "micro"'
        raise UsageError(f"microsteps: found {found}; {remedy}")
