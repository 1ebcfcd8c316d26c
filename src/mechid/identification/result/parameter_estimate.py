"""Estimate of one parameter: value, standard errors, interval, and the effect of its prior."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass

from scipy.special import stdtrit


@dataclass(frozen=True, kw_only=True)
class PriorShare:
    """A prior of the mechanism file, and its effect.

    Attributes
    ----------
    value, sigma : float
        In the parameter's unit.
    std_error_without : float or None
        White standard error of the parameter from the records alone, without any prior; infinite where they do not
        determine it. None where the parameter is not estimated or the prior did not count.
    counted : bool
        Whether the prior counted in the last fit.
    """

    value: float
    sigma: float
    std_error_without: float | None = None
    counted: bool = False

    @property
    def dominates(self) -> bool:
        """Whether the prior determines the parameter better than the records do."""
        return self.std_error_without is not None and self.std_error_without > self.sigma


@dataclass(frozen=True, kw_only=True)
class ParameterEstimate:
    """One parameter of the mechanism file after the fit, in the file's coordinates and unit.

    Attributes
    ----------
    std_error : float or None
        Standard error with model error included. All errors are None unless the parameter is free.
    std_error_noise, std_error_white : float or None
        Standard error by noise of any colour alone, and by white noise alone.
    std_error_clock : float or None
        Part of `std_error` from the choice of clock: the shift of the value if the driver's clock is right instead of
        the recorder's. None where the two agree, or the campaign declares the right one.
    dof : float or None
        Degrees of freedom of Student's t, by which the interval follows from `std_error`; None stands for the normal
        distribution.
    local_only : bool
        Whether the cost within the standard error departs from the quadratic, so that the error is not reliable;
        `reason` gives the place.
    contradicted : bool
        Whether the optimum of the records lies beyond its bound by more than chance.
    at_physical_limit : bool
        The same for a limit of physics, such as a damping of 0, which no wider range removes.
    one_sided : (float, float) or None
        95 % interval on a bound that is not contradicted, or on a limit of physics.
    added : bool
        Whether it belongs to a term or law that the fit added, since the mechanism file lacks it.
    """

    name: str
    symbol: str
    unit: str
    value: float
    std_error: float | None
    std_error_white: float | None
    start: float
    min: float | None
    max: float | None
    status: str
    reason: str = ""
    local_only: bool = False
    prior: PriorShare | None = None
    std_error_noise: float | None = None
    std_error_clock: float | None = None
    dof: float | None = None
    contradicted: bool = False
    one_sided: tuple[float, float] | None = None
    at_physical_limit: bool = False
    added: bool = False

    @property
    def ci95(self) -> tuple[float, float] | None:
        """95 % interval from the standard error; one-sided at a bound; None where there is neither."""
        if self.std_error is None:
            return self.one_sided
        # Infinite degrees of freedom give the normal quantile.
        reach = self.std_error * float(stdtrit(math.inf if self.dof is None else self.dof, 0.975))
        return self.value - reach, self.value + reach

    def to_dict(self) -> dict[str, object]:
        """Return the entry of estimate.json."""
        return {
            "value": self.value,
            "unit": self.unit,
            "symbol": self.symbol,
            "std_error": self.std_error,
            "std_error_noise": self.std_error_noise,
            "std_error_white": self.std_error_white,
            "std_error_clock": self.std_error_clock,
            "dof": self.dof,
            "ci95": list(self.ci95) if self.ci95 else None,
            "start": self.start,
            "min": self.min,
            "max": self.max,
            "status": self.status,
            "reason": self.reason,
            "local_only": self.local_only,
            "prior": asdict(self.prior) if self.prior else None,
            "contradicted": self.contradicted,
            "at_physical_limit": self.at_physical_limit,
            "added": self.added,
        }
