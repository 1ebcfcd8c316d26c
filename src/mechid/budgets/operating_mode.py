"""Mode of operation: steady rates or a rate profile, and its analysis settings."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.command import Command
from mechid.errors import InputFileError, UsageError
from mechid.plant.mechanism import Mechanism

SETTLE_S, HIGHEST_HZ, RMS_WINDOW_S = 1.0, 500.0, 1.0
MOST_HZ = 2000.0
"""Largest default for `highest_hz`: lines of the microsteps are included up to here."""
BESIDE_MICROSTEPS = 2
"""Orders above that of the microsteps that the default includes."""


@dataclass(frozen=True, kw_only=True)
class OperatingMode:
    """Mode of operation: one steady rate, several steady rates, or a profile.

    Parameters
    ----------
    name : str
    command : Command
        In a steady mode its rate is replaced by each of `rates`.
    rates : (r,)
        Full steps/s, ascending, not zero; empty for a profile.
    refined : bool
        Whether rates are added where orders cross modes, because the steps of a range may miss a narrow resonance.
    settle_s : float
        Time from the start until a motion is taken as steady.
    highest_hz : float
        Lines above are left out; `usual_highest_hz` if the file gives none.
    duration_s : float
        Of a profile, from the start at rest; 0 for a steady mode.
    rms_window_s : float
        Window of a profile's RMS.
    duty : float or None
        Share of the evaluation period in which this mode runs.
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
        """Frequency of voltage switching at the highest rate, at which there is a line."""
        return self.command.steps_per_full_step * self.highest_rate

    @property
    def is_profile(self) -> bool:
        """Whether the rate varies during the mode."""
        return self.rates.size == 0

    @property
    def highest_rate(self) -> float:
        """Largest magnitude of the rate, full steps/s."""
        return float(np.abs(self.command.rate.rates if self.is_profile else self.rates).max())

    def for_mechanism(self, mechanism: Mechanism) -> OperatingMode:
        """Return the mode with its command as a mechanism's motor and driver follow it.

        Raises
        ------
        InputFileError
            The motor cannot have the command, or a step is shorter than a pulse.
        """
        try:
            if mechanism.pulse:
                mechanism.pulse.check(self.microstep_hz)
            return replace(self, command=mechanism.command_for(self.command))
        except UsageError as error:
            raise InputFileError(f"mode {self.name}: {error}") from error


def usual_highest_hz(command: Command, highest_rate: float) -> float:
    """Return the default highest frequency, which includes the lines of the microsteps and their neighbours.

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
    # Fine microstepping would otherwise ask for lines far above any structural mode, and for as many samples.
    return min(max(HIGHEST_HZ, wanted), MOST_HZ)
