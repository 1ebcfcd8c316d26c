"""Record that would confirm the improvement: how long the found table has to run on the bench of the records.

The lines of a torque have the mean square M. Over T seconds, in noise of the one-sided density S, each of n lines has
the noise's mean square S/T, whose mean is known. What is left of it is an error of M with the variance

    2 M S/T + n (S/T)^2.

The first term is the noise beside each line, the second its own square.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mechid.campaign.channel_entry import TORQUE
from mechid.identification.result.fit import Fit
from mechid.quiet_drives.improvement import LineAt
from mechid.quiet_drives.settings import QUIET


@dataclass(frozen=True)
class Confirmation:
    """Record that shows the level after the change at one rate.

    Attributes
    ----------
    rate : float
        Full steps/s.
    seconds : float
        Length at a constant rate after which the RMS is known to `QUIET.confirmed_db` with 95 %.
    """

    rate: float
    seconds: float


def noise_density(fit: Fit) -> float | None:
    """Return the median one-sided noise density of the torque records in (N m)^2/Hz; None without read records.

    The noise counts as white, with the level that the fit took for it.
    """
    if fit.campaign is None:
        return None
    rates = {record.name: record.data.sample_rate_hz for record in fit.campaign.records if record.data is not None}
    found = [
        2.0 * own.channels[TORQUE].noise_sigma ** 2 / rates[name]
        for name, own in fit.records.items()
        if name in rates and TORQUE in own.channels
    ]
    return float(np.median(found)) if found else None


def confirm(lines: Sequence[LineAt], density: float | None) -> tuple[Confirmation, ...]:
    """Return the record that shows the level of lines of the torque at each of their rates, in noise of a density.

    Examples
    --------
    >>> lines = [LineAt(30.0, k, 1e-4, 1e-4) for k in range(1, 201)]
    >>> [round(one.seconds, 1) for one in confirm(lines, 1e-9)]
    [0.2]
    """
    if density is None:
        return ()
    squares = {rate: [one.amplitude**2 for one in lines if one.rate == rate] for rate in {one.rate: 0 for one in lines}}
    return tuple(
        Confirmation(rate, _seconds(0.5 * sum(own), len(own), density)) for rate, own in squares.items() if any(own)
    )


def _seconds(mean_square: float, lines: int, density: float) -> float:
    """Return the T at which the variance is that of an error of `QUIET.confirmed_db` at 95 %."""
    relative = (10.0 ** (0.1 * QUIET.confirmed_db) - 1.0) / QUIET.two_sided
    # With q = S / (T M): 2 q + n q^2 = relative^2.
    q = (np.sqrt(1.0 + lines * relative**2) - 1.0) / lines
    return float(density / (q * mean_square))
