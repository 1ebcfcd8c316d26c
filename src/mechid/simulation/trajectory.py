"""Results of a simulation: samples, sensitivities, switches and outcome."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum
from typing import TYPE_CHECKING

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.display import DisplayedResult
from mechid.signal.series import Series
from mechid.signal.stored_series import pieces_of

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.axes import Axes


class SimulationOutcome(Enum):
    """Outcome of a simulation; the value is a sentence for the user."""

    COMPLETE = "The record was simulated to its end."
    DIVERGED = "The mechanism diverged; samples from that instant on are lost."
    CHATTER = "More than 64 stick/slip switches fell into one step; samples from that instant on are lost."
    NO_EQUILIBRIUM = 'No mechanical equilibrium near the start angle; use start = "commanded". All samples are lost.'


@dataclass(frozen=True)
class Switching:
    """Switches of a run (stick-slip and others), in order of time.

    Attributes
    ----------
    time : (m,) s of command time
    switch : (m,) index into the plant's switches
    before, after : (m,) index of the mode
    slope : (m,) rate of the guard's margin where it fires; near zero the switch grazes
    sensitivity : (m, n) derivative of the instant with respect to the parameters, s per parameter's unit
    """

    time: FloatArray
    switch: IntArray
    before: IntArray
    after: IntArray
    slope: FloatArray
    sensitivity: FloatArray


@dataclass(frozen=True, repr=False)
class Trajectory(DisplayedResult):
    """A simulated record.

    Attributes
    ----------
    time : (n,) s of record time
    values : mapping of quantity to (n,)
        In SI units, e.g. ``values["torque"]`` in N m; NaN from the sample on at which it diverged.
        Both are arrays, or series that are read piece by piece for a long record that is only written to a file.
    jacobian : mapping of quantity to (n, m), or empty
        Derivatives with respect to the kernel's parameters `parameters`.
    rate : mapping of quantity to (n,), or empty
        Time derivative; its negative is the derivative with respect to a time offset.
    parameters : tuple of str
    switching : Switching
    outcome : SimulationOutcome
    substeps : int
        Integration steps per sample.
    difference : float or None
        RMS difference from the run with half as many steps, relative to the RMS torque, if it was computed.
    """

    time: Series
    values: Mapping[str, Series]
    jacobian: Mapping[str, FloatArray]
    rate: Mapping[str, FloatArray]
    parameters: tuple[str, ...]
    switching: Switching
    outcome: SimulationOutcome
    substeps: int = 1
    difference: float | None = None

    @property
    def lost_from_s(self) -> float | None:
        """Record time in s of the first lost sample, or None."""
        y = next(iter(self.values.values()))
        for part in pieces_of(y):
            lost = part.start + np.flatnonzero(~np.isfinite(y[part]))
            if lost.size:
                return float(self.time[lost[0] : lost[0] + 1][0])
        return None

    @property
    def in_memory(self) -> Trajectory:
        """The same trajectory with time and values as arrays."""
        return replace(self, time=self.time[:], values={quantity: y[:] for quantity, y in self.values.items()})

    @property
    def quantity(self) -> str:
        """The measured quantity, or the first of several."""
        return next(iter(self.values))

    @property
    def measured(self) -> FloatArray:
        """Samples of `quantity`, (n,) in its SI unit."""
        return self.values[self.quantity][:]

    @property
    def torque(self) -> FloatArray:
        """Measured torque, (n,) in N m."""
        return self.values["torque"][:]

    def plot(self, quantity: str | None = None, *, ax: Axes | None = None) -> Axes:
        """Plot a quantity over time, by default the measured one; return the axes, new ones without `ax`.

        Raises
        ------
        UsageError
            There is no such quantity.
        """
        # Imported here: matplotlib is slow to load, and a simulation does not need it.
        from mechid.ink.axes import Clock, axes_or_new, draw_over_time, one_of
        from mechid.ink.palette import MODELLED

        quantity, axes = one_of(quantity, self.values, "quantity"), axes_or_new(ax)
        step_s = float(self.time[1:2][0] - self.time[:1][0]) if self.time.size > 1 else 1.0
        clock, style = Clock(1.0 / step_s, float(self.time[:1][0])), {"linewidth": 0.8, "label": "modelled"}
        draw_over_time(axes, self.values[quantity], clock, quantity, color=MODELLED, **style)
        return axes

    def to_pandas(self) -> pd.DataFrame:
        """Return the samples as a DataFrame indexed by time (needs the extra ``dataframes``)."""
        import pandas as pd

        return pd.DataFrame({k: v[:] for k, v in self.values.items()}, index=pd.Index(self.time[:], name="time_s"))

    def to_xarray(self) -> xr.Dataset:
        """Return the samples as a Dataset over time (needs the extra ``dataframes``)."""
        import xarray as xr

        return xr.Dataset({k: ("time_s", v[:]) for k, v in self.values.items()}, coords={"time_s": self.time[:]})
