"""One parameter after the fit: its value, its errors, its interval, and what a prior did."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass

from scipy.special import stdtrit


@dataclass(frozen=True, kw_only=True)
class PriorShare:
    """A prior of the mechanism file, and what it did.

    Attributes
    ----------
    value, sigma : float
        In the parameter's unit.
    std_error_without : float or None
        White standard error of the parameter from the records alone, no prior counted; infinite where they do not
        tell it. None where the parameter is not estimated or the prior did not count.
    counted : bool
        Whether the prior counted in the last fit.
    """

    value: float
    sigma: float
    std_error_without: float | None = None
    counted: bool = False

    @property
    def dominates(self) -> bool:
        """Whether the prior says more of the parameter than the records do."""
        return self.std_error_without is not None and self.std_error_without > self.sigma


@dataclass(frozen=True, kw_only=True)
class ParameterEstimate:
    """One parameter of the mechanism file after the fit, in the file's coordinates and unit.

    `std_error` holds where the model lacks something too, `std_error_noise` counts noise of any colour alone,
    `std_error_white` white noise alone; all are None unless the parameter is free. `std_error_clock` is the part of
    `std_error` by which the value moves where the driver's clock is right instead of the recorder's; None where the two
    agree, or it is declared which one is right. `dof`: degrees of freedom of
    Student's t, by which the interval follows from `std_error`; None: so many that it is the normal distribution.
    `local_only`: the cost within its standard error is not what the derivatives
    say, so that the error is none to rely on; `reason` says where. `contradicted`: the records want it beyond
    its bound by more than chance; `at_physical_limit`: the same of a limit of physics, as a damping at 0, which no
    wider range mends. `one_sided`: its 95 % interval on a bound that is not contradicted, or on a limit of physics.
    `added`: it is of a term or law that the fit added, because the records need it and the mechanism file lacks it.
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
        """95 % interval from the standard error; one-sided at a bound; or None."""
        if self.std_error is None:
            return self.one_sided
        reach = self.std_error * float(stdtrit(math.inf if self.dof is None else self.dof, 0.975))
        return self.value - reach, self.value + reach

    def to_dict(self) -> dict[str, object]:
        """Return what estimate.json says of it."""
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
