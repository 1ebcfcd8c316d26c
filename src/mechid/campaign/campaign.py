"""A campaign: records with their commands, the mechanism they were taken from, and stages of the fit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, TypeAlias

from mechid.campaign.identify_options import IdentifyOptions
from mechid.command import ClockReference, Command, Timing
from mechid.errors import UsageError, did_you_mean
from mechid.parameter import Declaration, Parameter, Status
from mechid.plant.mechanism import Mechanism
from mechid.records import Mounting, Record, RecordSpec
from mechid.records.in_memory import SampleColumns

Use: TypeAlias = Literal["estimate", "validate"]

USES: tuple[Use, ...] = ("estimate", "validate")
TIME_OFFSET = Declaration(
    "time_offset_s", "t_0", "s", "record time at which the command starts", source="the test stand", default=0.0
)
START = "start"
"""What the states of a record's start are named by, ``record.<name>.start.<state>``."""
CLOCK = Declaration(
    key="clock_ppm",
    symbol="c",
    unit="ppm",
    meaning="by how much the driver's clock runs faster than the recorder's",
    lower=-1e5,
    upper=1e5,
    source="the test stand",
    default=0.0,
)
INSTANTS = (TIME_OFFSET, CLOCK)
"""What a ``[[record]]`` may say of its instants, ``record.<name>.<key>``."""
CAMPAIGN = "campaign"
"""Owner of what all records share, ``campaign.clock_ppm``."""


@dataclass(frozen=True, kw_only=True)
class Match:
    """A measured channel that the model has to explain, and how it counts.

    Parameters
    ----------
    quantity : str
    use : {"estimate", "validate"}
        Whether it is fitted, or only compared.
    offset, drift : bool
        Whether an offset and a linear drift are projected out.
    quantisation : float
        Resolution of the instrument in the file's numbers, 0 where none is declared.
    noise_sigma : float or None
        Standard deviation that its residual is to be judged by, in the file's numbers; None takes its noise floor.
    lines_hz : tuple of float
        Lines that are projected out, such as mains hum.
    offset_assumed : bool
        Whether `offset` is a default, which nobody has written.
    """

    quantity: str = "torque"
    use: Use = "estimate"
    offset: bool = True
    drift: bool = True
    quantisation: float = 0.0
    noise_sigma: float | None = None
    lines_hz: tuple[float, ...] = ()
    offset_assumed: bool = False


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class CampaignRecord:
    """One test run: how it was commanded, and what was measured.

    Parameters
    ----------
    name : str
        Of letters, digits, ``_`` and ``-``; it becomes a file name.
    use : {"estimate", "validate"}
        Whether it is fitted, or only compared.
    command : Command
    spec : RecordSpec
        What of the file is read.
    file : Path or None
        The measured file; None where the campaign names none.
    matches : tuple of Match
        The channels that the model has to explain, the leading one first: the torque where it is among them.
    parameters : tuple of Parameter
        Its time offset; its clock where it has one, or that of all records; values of the mechanism for it alone; the
        states of its start.
    burn_in_s : float
        Time at its beginning that is simulated and does not count.
    stretch_s : float
        Length of the stretches in which it is followed; 0 where it is followed as a whole.
    data : Record or None
        What the file holds, where it was read.
    clock_reference : {"recorder", "driver"}
        Whose time is the true one, where the driver's clock and the recorder's differ.
    """

    name: str
    use: Use
    command: Command
    spec: RecordSpec
    file: Path | None = None
    matches: tuple[Match, ...] = (Match(),)
    parameters: tuple[Parameter, ...] = ()
    burn_in_s: float = 0.0
    stretch_s: float = 0.0
    data: Record | None = None
    clock_reference: ClockReference = "recorder"

    def __repr__(self) -> str:
        held = "planned" if self.data is None and self.file is None else repr(self.data) if self.data else "not read"
        return f"<CampaignRecord {self.name} ({self.use}): {held}>"

    @property
    def estimated(self) -> tuple[Match, ...]:
        """The channels that are fitted."""
        return tuple(match for match in self.matches if match.use == "estimate")

    @property
    def leading(self) -> str:
        """The quantity of the first channel that is fitted."""
        return self.estimated[0].quantity

    @property
    def replaced(self) -> tuple[Parameter, ...]:
        """Values of the mechanism for it alone, ``record.<name>.transducer.gain`` and the like."""
        return tuple(q for q in self.parameters if q.replaces)

    @property
    def start(self) -> tuple[Parameter, ...]:
        """The states of its start, ``record.<name>.start.angle`` and the like; none where it starts at rest."""
        return tuple(q for q in self.parameters if is_of_start(q))

    @property
    def time_offset(self) -> Parameter:
        """Record time in s at which the command starts."""
        return next(q for q in self.parameters if q.declaration.key == TIME_OFFSET.key)

    @property
    def clock(self) -> Parameter | None:
        """By how many ppm the driver's clock runs faster than its recorder's; None where nothing is said of it."""
        return next((q for q in self.parameters if q.declaration.key == CLOCK.key), None)

    def holding(self, values: Mapping[str, float]) -> CampaignRecord:
        """Return the record with those of its own parameters known that have a value here, by dotted name."""
        held = (
            replace(q, value=values[q.name], status=Status.KNOWN) if q.name in values else q for q in self.parameters
        )
        return replace(self, parameters=tuple(held))

    @property
    def timing(self) -> Timing:
        """How record time becomes command time, at the values of the file."""
        return Timing(self.time_offset.value, self.clock.value if self.clock else 0.0, self.clock_reference)


@dataclass(frozen=True)
class Stage:
    """One stage of the search as the user asks for it.

    Parameters
    ----------
    records : tuple of str
        Names of the records it fits.
    window_s : (float, float) or None
        Record time in s from and to which they count; None is all of them.
    free : tuple of str
        Dotted names of the parameters it moves.
    """

    records: tuple[str, ...]
    window_s: tuple[float, float] | None
    free: tuple[str, ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class InCode:
    """What a campaign that is in no file was made of.

    Parameters
    ----------
    entries : mapping
        What campaign.toml would hold of it.
    samples : mapping of str to SampleColumns
        By the names of the records that were measured.
    """

    entries: Mapping[str, Any]
    samples: Mapping[str, SampleColumns]


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Campaign:
    """Records, mechanism and stages that belong together.

    Parameters
    ----------
    path, mechanism_path : Path
        The files they were read from.
    mechanism : Mechanism
    records : tuple of CampaignRecord
        In the order of the file.
    mounting : Mounting or None
        How the mechanism stands on a table that measures more than its torque.
    stages : tuple of Stage
        Empty where mechid is to plan them.
    options : IdentifyOptions
    considered : tuple of str
        Names of the effects that a diagnosis looks for; empty where it looks for all.
    warnings : tuple of str
        What is odd and yet usable, one line each.
    synthetic : bool
        Whether the records were simulated, not measured; every result of them says so.
    source : InCode or None
        What it was made of; None where it was read from files.
    clock_reference : {"recorder", "driver"} or None
        Whose clock is right, where it is declared.
    """

    path: Path
    mechanism_path: Path
    mechanism: Mechanism
    records: tuple[CampaignRecord, ...]
    mounting: Mounting | None = None
    stages: tuple[Stage, ...] = ()
    options: IdentifyOptions = field(default_factory=IdentifyOptions)
    considered: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    synthetic: bool = False
    source: InCode | None = None
    clock_reference: ClockReference | None = None

    def __repr__(self) -> str:
        names = ", ".join(record.name for record in self.records)
        return f"<Campaign {self.path}: {len(self.free)} free parameters, records {names}>"

    def record(self, name: str) -> CampaignRecord:
        """Return the record of a name; UsageError where there is none."""
        by_name = {record.name: record for record in self.records}
        if name not in by_name:
            near = did_you_mean(name, by_name) or "; there are " + ", ".join(by_name)
            raise UsageError(f'{self.path.name}: no record "{name}"{near}')
        return by_name[name]

    @property
    def estimated(self) -> tuple[CampaignRecord, ...]:
        """The records that are fitted."""
        return tuple(record for record in self.records if record.use == "estimate")

    @property
    def validated(self) -> tuple[CampaignRecord, ...]:
        """The records that are only compared."""
        return tuple(record for record in self.records if record.use == "validate")

    @cached_property
    def parameters(self) -> dict[str, Parameter]:
        """The mechanism's parameters, then those of each record, by dotted name."""
        return parameters_of(self.mechanism, self.records)

    @property
    def free(self) -> tuple[Parameter, ...]:
        """Parameters the fit may move, those of records included."""
        return tuple(q for q in self.parameters.values() if q.is_free)


def parameters_of(mechanism: Mechanism, records: tuple[CampaignRecord, ...]) -> dict[str, Parameter]:
    """Return all parameters by dotted name."""
    own = {q.name: q for record in records for q in record.parameters}
    return {**mechanism.parameters, **own}


def key_in_record(record_parameter: str) -> str:
    """Return what a record's own parameter is called behind its record's name.

    Examples
    --------
    >>> key_in_record("record.full_46.transducer.gain")
    'transducer.gain'
    """
    return record_parameter.split(".", 2)[2]


def is_of_start(parameter: Parameter) -> bool:
    """Tell whether a record's own parameter is a state of its start."""
    return parameter.declaration.key.startswith(f"{START}.")


def names_start(name: str) -> bool:
    """Tell whether a dotted name is that of a state of a record's start.

    Examples
    --------
    >>> names_start("record.full_46.start.angle"), names_start("load.start_rate")
    (True, False)
    """
    return name.startswith("record.") and key_in_record(name).startswith(f"{START}.")


def record_parameter_name(record: str, key: str) -> str:
    """Return the dotted name of a record's own parameter."""
    return f"record.{record}.{key}"
