"""Rules of the grade, of held-out records and of the messages of a result."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class GradeRules:
    """What a fit has to keep for its grade."""

    by_chance: float = 4.0
    """Standard deviations of chance up to which parts that scatter agree: 17 campaigns with a complete model reached
    0.9 at most, and of 41 with an effect left out 39 exceeded it."""

    held_out_worse: float = 2.0
    """Times the noise, and times what the fitted records leave of theirs, from which a held-out record is predicted
    badly. Complete models leave 0.95 to 1.06 times the noise of held-out records (docs/identification.md)."""
    louder: float = 2.0
    """Times the noise, and times what is left of the other records, from which a fitted record holds something that the
    model does not. Complete models leave 0.95 to 1.06 times; a knock of 0.1 s left 4.7 times the noise of one record
    of six, 1.01 times that of the others, with grade A."""
    held_out_lost: float = 0.5
    """Share of the measured RMS above which the residual of a badly predicted record means that it is not followed:
    half, as in each window of a fitted record (`signal.following`)."""

    # The others are choices; no benchmark distinguishes values near them.

    near_optimum: float = 0.1
    """Share of the cost that may still be promised where a fit stopped at its limit of steps, for its step to count in
    the errors; beyond it there is no optimum near."""
    near_bound: float = 1e-3
    """Share of its range within which a bound may hold a parameter of a fit that stopped short of it."""
    least_of_noise: float = 0.5
    """Residual over noise below which the declared noise level is wrong: a residual holds all of the noise."""
    near_multiple: float = 0.01
    """Relative distance within which lines belong to one multiple of the grid frequency."""
    most_named: int = 8
    """Values that a warning names."""
    noted_every_s: float = 1.0
    """Least time between two notes of where the search stands."""


@dataclass(frozen=True)
class HeldOutSettings:
    """The first part of a held-out record, on which its own parameters are fitted. All are choices."""

    first_share: float = 0.1
    """Least length of the first part, as a share of the record from where its motion begins."""
    largest_share: float = 0.5
    """Greatest length of the first part, as a share of the whole record."""
    first_steps: float = 16.0
    """Full steps that the first part holds, four electrical turns."""
    moves: float = 0.1
    """Share of the largest swing of a record under a measured input, from which on it moves."""
    instants: int = 20_000
    """Instants at which the travel of a command is looked at."""
    most_offsets: int = 256
    """Time offsets that are tried over the declared range."""
    fine_offsets: int = 33
    """Time offsets that are tried about each of the best."""
    branches: int = 3
    """Best time offsets that are refined."""


GRADE = GradeRules()
HELD_OUT = HeldOutSettings()
