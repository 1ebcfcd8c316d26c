"""Where a run of the slow twin stands, and what it returns."""

from __future__ import annotations

from dataclasses import dataclass

from mechid.arrays import FloatArray


@dataclass(frozen=True, kw_only=True)
class TwinState:
    """Where a run stands.

    Attributes
    ----------
    time : float
        Command time in s.
    s : (n,) array
        States of the plant, then of its filter, SI units.
    S : (n, m) array
        Their derivatives to the sensitive parameters.
    inputs : (i,) array
        Excitation.
    modes : tuple of int
        Mode of each switch.
    armed : tuple of tuple of bool
        For each guard of those modes, whether it has stood above zero since the mode began.
    """

    time: float
    s: FloatArray
    S: FloatArray
    inputs: FloatArray
    modes: tuple[int, ...]
    armed: tuple[tuple[bool, ...], ...]


@dataclass(frozen=True, kw_only=True)
class TwinSwitch:
    """One switch: its instant in s and that instant's derivatives (m,), modes before and after."""

    time: float
    switch: int
    before: int
    after: int
    sensitivity: FloatArray


@dataclass(frozen=True, kw_only=True)
class TwinRun:
    """What a run returns: y (n, n_y), jacobian (n, n_y, m), the switches, and where it ended.

    `rate` = dy/dt (n, n_y) is filled only where there are sensitive parameters.
    """

    y: FloatArray
    rate: FloatArray
    jacobian: FloatArray
    switching: tuple[TwinSwitch, ...]
    end: TwinState
