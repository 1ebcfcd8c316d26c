"""Test of a residual against its record's noise, by the number of independent samples."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from mechid.analysis.settings import RESIDUAL
from mechid.identification.uncertainty.settings import NOISE
from mechid.signal.noise import FLOOR_ERROR


class NoiseLevel(Enum):
    """How a residual stands to the noise floor."""

    NOISE = "no larger than white noise of the floor's level gets by chance"
    COLOURED = "no larger than chance allows for so few effective samples, but larger than white noise gets"
    ABOVE = "larger than chance explains"
    LOST = "none: the simulation does not come to its end"


@dataclass(frozen=True, kw_only=True)
class AgainstNoise:
    """A residual beside the noise floor of its record.

    Attributes
    ----------
    residual_rms, noise_sigma : float
        In the channel's unit; NaN where there is none.
    samples : int
        That count in the residual.
    effective_samples : float
        How many independent ones they are worth, `signal.effective_samples`.
    floor_samples : int
        From which the floor was read.
    """

    residual_rms: float
    noise_sigma: float
    samples: int
    effective_samples: float
    floor_samples: int

    @property
    def ratio(self) -> float:
        """Residual RMS over noise floor, NaN where there is none."""
        return self.residual_rms / self.noise_sigma if self.noise_sigma > 0.0 else math.nan

    @property
    def most_by_chance(self) -> float:
        """The largest ratio that chance explains with so many effective samples."""
        return most_by_chance(self.effective_samples, self.floor_samples)

    @property
    def level(self) -> NoiseLevel:
        """The judgement.

        What a model misses is mostly a few lines, which make a residual of few effective samples: that alone must
        not excuse its size. So "noise" is only what white noise gets, of which all samples are independent.
        """
        if not math.isfinite(self.ratio):
            return NoiseLevel.LOST
        if self.ratio <= most_by_chance(self.samples, self.floor_samples):
            return NoiseLevel.NOISE
        return NoiseLevel.COLOURED if self.ratio <= self.most_by_chance else NoiseLevel.ABOVE

    @property
    def is_noise(self) -> bool:
        """Whether the residual is explained down to the noise."""
        return self.level is NoiseLevel.NOISE


def most_by_chance(effective_samples: float, floor_samples: int) -> float:
    """Return the largest ratio of a residual's RMS to its noise floor that chance explains.

    The RMS of n independent samples has the relative standard error sqrt(1 / 2n), the floor its own of about
    1.7 / sqrt(N). However few samples there are, the search weights what is above `NOISE.misfit` as a misfit.

    Parameters
    ----------
    effective_samples : float
        n, of the residual; NaN counts as one.
    floor_samples : int
        N, of the record from which the floor was read.

    Examples
    --------
    >>> round(most_by_chance(10_001, 10_001), 3), round(most_by_chance(600_001, 600_001), 4)
    (1.074, 1.0095)
    >>> most_by_chance(30, 10_001)
    1.2
    """
    n = effective_samples if effective_samples >= 1.0 else 1.0
    error = math.sqrt(0.5 / n + FLOOR_ERROR**2 / max(floor_samples, 1))
    return min(1.0 + RESIDUAL.noise_errors * error, NOISE.misfit)
