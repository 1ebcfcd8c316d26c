"""Test of a residual against the noise floor of its record, by the number of independent samples."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from mechid.analysis.settings import RESIDUAL
from mechid.identification.uncertainty.settings import NOISE
from mechid.signal.noise import FLOOR_ERROR


class NoiseLevel(Enum):
    """Level of a residual relative to the noise floor."""

    NOISE = "no larger than white noise of the floor's level gets by chance"
    COLOURED = "no larger than chance allows for so few effective samples, but larger than white noise gets"
    ABOVE = "larger than chance explains"
    LOST = "none: the simulation does not come to its end"


@dataclass(frozen=True, kw_only=True)
class NoiseComparison:
    """Residual and noise floor of one channel.

    Attributes
    ----------
    residual_rms, noise_sigma : float
        In the channel's unit; NaN if unknown.
    samples : int
        Number of samples counted in the residual.
    effective_samples : float
        Effective sample count of the residual, `signal.effective_samples`.
    floor_samples : int
        Number of samples from which the floor was estimated.
    """

    residual_rms: float
    noise_sigma: float
    samples: int
    effective_samples: float
    floor_samples: int

    @property
    def ratio(self) -> float:
        """Residual-to-noise ratio; NaN if unknown."""
        return self.residual_rms / self.noise_sigma if self.noise_sigma > 0.0 else math.nan

    @property
    def most_by_chance(self) -> float:
        """Largest ratio that chance explains with this effective sample count."""
        return most_by_chance(self.effective_samples, self.floor_samples)

    @property
    def level(self) -> NoiseLevel:
        """Level of the residual.

        Model errors mostly appear as a few spectral lines, and such a residual has few effective samples. A low count
        must not excuse a large residual. "Noise" therefore allows only for the scatter of white noise, whose samples
        are all independent.
        """
        if not math.isfinite(self.ratio):
            return NoiseLevel.LOST
        if self.ratio <= most_by_chance(self.samples, self.floor_samples):
            return NoiseLevel.NOISE
        return NoiseLevel.COLOURED if self.ratio <= self.most_by_chance else NoiseLevel.ABOVE

    @property
    def is_noise(self) -> bool:
        """Whether the residual is at the level of white noise."""
        return self.level is NoiseLevel.NOISE


def most_by_chance(effective_samples: float, floor_samples: int) -> float:
    """Return the largest residual-to-noise ratio that chance explains.

    The RMS of n independent samples has the relative standard error sqrt(1 / 2n); the error of the floor is about
    1.7 / sqrt(N). The limit never exceeds `NOISE.misfit`, above which the search weights a residual as a misfit.

    Parameters
    ----------
    effective_samples : float
        n, effective sample count of the residual; NaN counts as one.
    floor_samples : int
        N, number of samples from which the floor was estimated.

    Examples
    --------
    >>> round(most_by_chance(10_001, 10_001), 3), round(most_by_chance(600_001, 600_001), 4)
    (1.074, 1.0095)
    >>> most_by_chance(30, 10_001)
    1.2
    """
    # NaN fails the comparison and counts as one sample.
    n = effective_samples if effective_samples >= 1.0 else 1.0
    error = math.sqrt(0.5 / n + FLOOR_ERROR**2 / max(floor_samples, 1))
    return min(1.0 + RESIDUAL.noise_errors * error, NOISE.misfit)
