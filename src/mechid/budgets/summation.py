"""Summation by ECSS-E-ST-60-10C: mean and standard deviation of bias, random and periodic errors.

Annex B gives each kind's distribution for APE by statistical interpretation; with B its bias, s its standard
deviation over time, A its amplitude, each with mean mu and standard deviation sigma over the ensemble:

=========  ==========  =============  =====================
kind       ensemble    temporal       mixed
=========  ==========  =============  =====================
bias       mu_B        worst B        mu_B
           sigma_B     0              sigma_B
random     n_p mu_s    0              0
           n_p sig_s   worst s        (mu_s^2+sig_s^2)^1/2
periodic   mu_A        0              0
           sigma_A     worst A/2^1/2  ((mu_A^2+sig_A^2)/2)^1/2
=========  ==========  =============  =====================

Worst is the mean and n_p standard deviations. Means add, standard deviations add linearly within a correlated group
and by their squares between groups (4.2, A.2): total = |mean| + n_p sigma. A line's arcsine distribution enters by its
standard deviation A/2^1/2 only; where lines dominate, `levels` is exact and this is an upper bound for n_p > 1.41.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from scipy.special import ndtri

from mechid.errors import UsageError

KINDS = ("bias", "random", "periodic")


@dataclass(frozen=True, kw_only=True)
class Contribution:
    """Error of a budget.

    Parameters
    ----------
    name : str
    kind : str
        "bias", "random" (size: standard deviation over time) or "periodic" (size: amplitude).
    size, spread : float
        Mean and standard deviation of the size over the ensemble, rad.
    group : str
        Contributions of one group are correlated; empty is a group of its own.
    form : float
        Of a periodic error: root mean square over largest value; the default is that of a sine.
    """

    name: str
    kind: str
    size: float
    spread: float = 0.0
    group: str = ""
    form: float = math.sqrt(0.5)


def moments(c: Contribution, interpretation: str, n_p: float) -> tuple[float, float]:
    """Return mean and standard deviation of a contribution to APE, rad, by the table above.

    Raises
    ------
    UsageError
        The kind or the interpretation is unknown.
    """
    scale = {"bias": 1.0, "random": 1.0, "periodic": c.form}.get(c.kind)
    if scale is None:
        raise UsageError(f'{c.name}: unknown kind "{c.kind}"; write one of {", ".join(KINDS)}')
    worst = abs(c.size) + n_p * c.spread
    if interpretation == "temporal":
        return (worst, 0.0) if c.kind == "bias" else (0.0, scale * worst)
    if interpretation == "ensemble":
        times = n_p if c.kind == "random" else 1.0
        return times * c.size, times * c.spread
    if interpretation == "mixed":
        return (c.size, c.spread) if c.kind == "bias" else (0.0, scale * math.hypot(c.size, c.spread))
    raise UsageError(f'interpretation: unknown "{interpretation}"; write "temporal", "ensemble" or "mixed"')


def total(contributions: Sequence[Contribution], interpretation: str, confidence: float) -> float:
    """Return |mean| + n_p sigma of a sum, rad; n_p is the two-sided Gaussian factor of the confidence."""
    n_p = coverage_factor(confidence)
    groups: dict[str, float] = {}
    mean = 0.0
    for position, c in enumerate(contributions):
        mu, sigma = moments(c, interpretation, n_p)
        mean += mu
        # A leading space cannot occur in a group's name, so that a single error never joins a group.
        key = c.group or f" {position}"
        groups[key] = groups.get(key, 0.0) + sigma
    return abs(mean) + n_p * math.sqrt(sum(sigma**2 for sigma in groups.values()))


def coverage_factor(confidence: float, *, cone: bool = False) -> float:
    """Return n_p of a confidence: two-sided Gaussian, or Rayleigh for a cone about two equal axes.

    Examples
    --------
    >>> round(coverage_factor(0.9973), 2), round(coverage_factor(0.9973, cone=True), 2)
    (3.0, 3.44)
    """
    if not 0.0 < confidence < 1.0:
        raise UsageError(f"confidence: found {confidence}; write a share between 0 and 1, as 0.9973")
    if cone:
        return math.sqrt(-2.0 * math.log(1.0 - confidence))
    return float(ndtri(0.5 * (1.0 + confidence)))
