"""A parameter: what it means, in which unit, within which bounds, and what is believed of it.

`Declaration` is the parameter as its block knows it; `Parameter` is the same one in a user's
mechanism, with a value and a status. Values are in the file's own coordinates and units
(SI, or degrees where the key ends in ``_deg``).
"""

from __future__ import annotations

import math
from dataclasses import KW_ONLY, dataclass, field, replace
from enum import StrEnum

from mechid.units import angle_difference


class Status(StrEnum):
    """What the fit may do, or has done, with a parameter."""

    FREE = "free"
    KNOWN = "known"
    TIED = "tied"
    FROZEN = "frozen"
    AT_BOUND = "at_bound"


class Role(StrEnum):
    """What a parameter does in any mechanism, for those who change it without knowing the block."""

    SUPPLY = "supply"
    """Drives the motor: phase voltage or phase current, of which a weaker supply gives less."""
    LOAD_INERTIA = "load inertia"
    """The whole inertia that the output moves."""
    DRY_FRICTION = "dry friction"
    """A level of dry friction at the motor: torque that opposes motion whatever the speed."""
    WINDING_RESISTANCE = "winding resistance"
    """Of copper: it rises with the winding's temperature, by 0.39 % a kelvin."""
    TRANSDUCER_GAIN = "transducer gain"
    """What the transducer's conditioning makes of the torque."""
    CUT_OFF = "cut-off"
    """Of a low-pass in front of the recorder: the frequency above which it takes away."""


@dataclass(frozen=True)
class Declaration:
    """A parameter as declared by the block that uses it.

    Parameters
    ----------
    key : str
        Key in the mechanism file, relative to the block's table, e.g. ``"coil_resistance"``.
    symbol : str
        Symbol in the equations, e.g. ``"R"``.
    unit : str
        Unit of the file's value, e.g. ``"ohm"``; ``"1"`` where there is none.
    meaning : str
        One line for a reader who does not know the symbol.
    lower, upper : float
        Physical limits; a file's value outside them is refused.
    source : str
        Where the equation or the value stands.
    default : float or None
        Value where the file has none; None makes the key mandatory.
    structural : bool
        It shapes the equations or is a count: it is known, never estimated.
    spread : float
        Factor by which a catalogue value is typically wrong, either way; the search starts within it.
    typical : (str, float, float) or None
        Where no catalogue value is worth a start: a scale as an expression in the file's symbols, and the
        smallest and largest share of it met in practice.
    above : str or None
        Parameter below which it never lies, as static friction above Coulomb friction: it is searched by its excess
        over that one. Keys of other parameters, here and below, are relative to the same table, or dotted names.
    beyond : str or None
        Parameter that it has to exceed.
    part_of : str or None
        Parameter of which it is a part: all parts together stay below the whole.
    tied_to : str or None
        Parameter that it follows where the file does not name it.
    hertz_below : float
        A value in rad/s below this may be meant in hertz, and is asked about.
    percent_above : float
        A damping ratio above this may be meant in percent, and is asked about.
    even : bool
        It counts what comes in pairs.
    supply_power : int
        Power with which it follows the supply when torque and motion stay as they are: k_m goes with U, R and L go with
        U^2. Where all that follow it are free, no torque record tells them apart.
    role : Role or None
        What it does in a mechanism whatever the block calls it; margins and tables over it are made by role.
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
        """Return the question whether a value is meant in another unit; empty where nothing suggests it."""
        if 0.0 < value < self.hertz_below:
            return "is this in Hz? it is read in rad/s"
        if value > self.percent_above:
            ratio = f"{0.01 * value:.9g}"
            return f"is this in percent? it is read as a share of critical damping; write {ratio} for {value:.9g} %"
        return ""


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """A parameter of one mechanism or record: its dotted name, value, bounds and status.

    `sigma` is the standard deviation of a prior on the value, in the value's unit. `tied_to`
    names the parameter it follows when `status` is tied. `reason` says why a status is not the
    one that the file asked for. `replaces` names the mechanism's parameter in whose place a
    record's own one stands for that record; empty where it stands for none.
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
        """Whether the fit may move it."""
        return self.status is Status.FREE

    @property
    def is_periodic(self) -> bool:
        """Whether it is an angle in degrees whose range is a full turn, hence no real bound."""
        return self.declaration.unit == "deg" and self.max - self.min >= 360.0

    def moved_to(self, value: float) -> Parameter:
        """Return the same parameter at another value; a periodic one is wrapped to [-180, 180) if it lies outside."""
        if self.is_periodic and not -180.0 <= value < 180.0:
            value = angle_difference(value)
        return replace(self, value=value)
