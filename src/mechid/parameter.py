"""Parameters: declarations, values, bounds, priors and status.

`Declaration` is the parameter as its block declares it. `Parameter` is the same parameter in a user's mechanism, with a
value and a status. Values are in the coordinates and units of the file: SI, or degrees where the key ends in ``_deg``.
"""

from __future__ import annotations

import math
from dataclasses import KW_ONLY, dataclass, field, replace
from enum import StrEnum

from mechid.units import angle_difference


class Status(StrEnum):
    """Status of a parameter before or after a fit."""

    FREE = "free"
    KNOWN = "known"
    TIED = "tied"
    FROZEN = "frozen"
    AT_BOUND = "at_bound"


class Role(StrEnum):
    """Physical role of a parameter in any mechanism, independent of the block that declares it."""

    SUPPLY = "supply"
    """Drives the motor: phase voltage or phase current. A weaker supply lowers it."""
    LOAD_INERTIA = "load inertia"
    """Total inertia driven by the output."""
    DRY_FRICTION = "dry friction"
    """Level of dry friction at the motor: a torque that opposes motion at any speed."""
    WINDING_RESISTANCE = "winding resistance"
    """Of copper: it rises by 0.39 % per kelvin of winding temperature."""
    TEMPERATURE = "temperature"
    """Temperature of the motor above that of the file's values."""
    TRANSDUCER_GAIN = "transducer gain"
    """Gain of the transducer's signal conditioning."""
    CUT_OFF = "cut-off"
    """Of a low-pass in front of the recorder: the frequency above which it attenuates."""


@dataclass(frozen=True)
class Declaration:
    """A parameter as its block declares it.

    Parameters
    ----------
    key : str
        Key in the mechanism file, relative to the block's table, e.g. ``"coil_resistance"``.
    symbol : str
        Symbol in the equations, e.g. ``"R"``.
    unit : str
        Unit of the file's value, e.g. ``"ohm"``; ``"1"`` if dimensionless.
    meaning : str
        One line for a reader who does not know the symbol.
    lower, upper : float
        Physical limits; a value outside them is refused.
    source : str
        Reference for the equation or the value.
    default : float or None
        Value where the file has none; None makes the key mandatory.
    structural : bool
        The parameter shapes the equations or is a count: it is known, never estimated.
    spread : float
        Factor by which a catalogue value is typically wrong, either way; the search starts within it.
    typical : (str, float, float) or None
        For a parameter without a usable catalogue value: a scale as an expression in the file's symbols, and the
        smallest and the largest multiple of it met in practice.
    above : str or None
        Parameter that bounds it from below, as Coulomb friction bounds static friction: the search varies the excess
        over that parameter. Keys of other parameters, here and below, are relative to the same table, or dotted names.
    beyond : str or None
        Parameter that it has to exceed.
    part_of : str or None
        Parameter of which it is a part: the sum of all parts stays below the whole.
    tied_to : str or None
        Parameter that it follows if the file does not name it.
    hertz_below : float
        A value in rad/s below this may have been meant in hertz; the user is asked.
    percent_above : float
        A damping ratio above this may have been meant in percent; the user is asked.
    even : bool
        The parameter is an even count.
    supply_power : int
        Exponent with which it scales with the supply when torque and motion stay the same: k_m scales with U, R and L
        with U^2. If all parameters that scale so are free, no torque record identifies them.
    role : Role or None
        Physical role, independent of the block; margins and their tables are made by role.
    """

    key: str
    symbol: str
    unit: str
    meaning: str
    _: KW_ONLY
    lower: float = -math.inf
    upper: float = math.inf
    source: str = "Kornienko2013"
    default: float | None = None
    structural: bool = False
    spread: float = 2.5
    typical: tuple[str, float, float] | None = None
    above: str | None = None
    beyond: str | None = None
    part_of: str | None = None
    tied_to: str | None = None
    hertz_below: float = 0.0
    percent_above: float = math.inf
    even: bool = False
    supply_power: int = 0
    role: Role | None = None

    def doubt(self, value: float) -> str:
        """Return the question whether a value was meant in another unit, or an empty string."""
        if 0.0 < value < self.hertz_below:
            return "is this in Hz? it is read in rad/s"
        if value > self.percent_above:
            ratio = f"{0.01 * value:.9g}"
            return f"is this in percent? it is read as a share of critical damping; write {ratio} for {value:.9g} %"
        return ""


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """A parameter of one mechanism or record: its dotted name, value, bounds and status.

    `sigma` is the standard deviation of a prior on the value, in the value's unit. `tied_to` names the parameter that
    it follows when `status` is tied. `reason` says why the status differs from the one in the file. `replaces` names
    the mechanism's parameter that a per-record parameter replaces for its record; empty if it replaces none.
    """

    name: str
    value: float
    declaration: Declaration
    min: float = -math.inf
    max: float = math.inf
    sigma: float | None = None
    status: Status = Status.KNOWN
    tied_to: str | None = None
    reason: str = field(default="")
    replaces: str = ""

    @property
    def is_free(self) -> bool:
        """Whether the fit may change the value."""
        return self.status is Status.FREE

    @property
    def is_periodic(self) -> bool:
        """Whether the parameter is an angle in degrees with a range of a full turn, so that its bounds are none."""
        return self.declaration.unit == "deg" and self.max - self.min >= 360.0

    def at_value(self, value: float) -> Parameter:
        """Return the parameter at another value; a periodic value outside [-180, 180) is wrapped into that range."""
        if self.is_periodic and not -180.0 <= value < 180.0:
            value = angle_difference(value)
        return replace(self, value=value)
