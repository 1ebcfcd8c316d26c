"""A way in which the mechanism is driven."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray
from mechid.command import Command

SETTLE_S, HIGHEST_HZ, RMS_WINDOW_S = 1.0, 500.0, 1.0
MOST_HZ = 2000.0
"""Up to here the lines of the microsteps are kept without being asked for."""
BESIDE_MICROSTEPS = 2
"""Orders above that of the microsteps that are kept with it."""


@dataclass(frozen=True, kw_only=True)
class OperatingMode:
    """A way in which the mechanism is driven: at one steady rate, at each of several, or through a profile.

    Parameters
    ----------
    name : str
    command : Command
        Of a steady mode the rate is replaced by each of `rates`.
    rates : (r,)
        Full steps/s, ascending, not zero; none of a profile.
    refined : bool
        Whether rates are added where orders cross modes: of a range, whose steps may miss a narrow resonance.
    settle_s : float
        Time from the start until a steady motion counts as such.
    highest_hz : float
        Lines above are left out; `usual_highest_hz` where the file does not say.
    duration_s : float
        Of a profile, from the start at rest; 0 of a steady mode.
    rms_window_s : float
        Of a profile: the windows in which its RMS is taken.
    duty : float or None
        Share of the evaluation period in which this mode is run.
    """

    name: str
    command: Command
    rates: FloatArray
    refined: bool = False
    settle_s: float = SETTLE_S
    highest_hz: float = HIGHEST_HZ
    duration_s: float = 0.0
    rms_window_s: float = RMS_WINDOW_S
    duty: float | None = None

    @property
    def microstep_hz(self) -> float:
        """Frequency at which the voltages are switched at the highest rate: a line stands there."""
        return self.command.steps_per_full_step * self.highest_rate

    @property
    def is_profile(self) -> bool:
        """Whether the rate changes while it is run."""
        return self.rates.size == 0

    @property
    def highest_rate(self) -> float:
        """Largest magnitude of the rate, full steps/s."""
        return float(np.abs(self.command.rate.rates if self.is_profile else self.rates).max())


def usual_highest_hz(command: Command, highest_rate: float) -> float:
    """Return up to which frequency lines count where nothing is said: those of the microsteps and beside them too.

    Examples
    --------
    >>> from mechid.command import RateProfile
    >>> still = RateProfile.constant(0.0)
    >>> usual_highest_hz(Command(stepping="micro", microsteps=16, rate=still), 47.5)
    855.0
    >>> usual_highest_hz(Command(stepping="full", microsteps=1, rate=still), 92.0)
    500.0
    """
    wanted = (command.steps_per_full_step + BESIDE_MICROSTEPS) * highest_rate
    return min(max(HIGHEST_HZ, wanted), MOST_HZ)
