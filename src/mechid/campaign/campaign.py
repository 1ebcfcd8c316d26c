"""Campaign: records with their commands, the measured mechanism, and the stages of the fit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, TypeAlias

from mechid.campaign.declared_test import DeclaredTest
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
"""Prefix of the initial states of a record, ``record.<name>.start.<state>``."""
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
"""Timing parameters of a ``[[record]]``, named ``record.<name>.<key>``."""
CAMPAIGN = "campaign"
"""Prefix of parameters that all records share, as ``campaign.clock_ppm``."""


@dataclass(frozen=True, kw_only=True)
class Match:
    """A measured channel that the model has to explain, with its settings in the fit.

    Parameters
    ----------
    quantity : str
    use : {"estimate", "validate"}
        Whether the channel is fitted or only compared.
    offset, drift : bool
        Whether an offset and a linear drift are projected out.
    quantisation : float
        Resolution of the instrument in the units of the file; 0 if none is declared.
    noise_sigma : float or None
        Standard deviation of the noise in the units of the file; None takes the channel's noise floor.
    lines_hz : tuple of float
        Frequencies of lines that are projected out, such as mains hum.
    offset_assumed : bool
        Whether `offset` is a default rather than an entry of the file.
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
    """One test run: its command and its measured data.

    Parameters
    ----------
    name : str
        Letters, digits, ``_`` and ``-``; also used as a file name.
    use : {"estimate", "validate"}
        Whether the record is fitted or only compared.
    command : Command
    spec : RecordSpec
        Channels and settings with which the file is read.
    file : Path or None
        The measured file; None if the campaign names none.
    matches : tuple of Match
        The channels that the model has to explain, the leading one first: the torque if it is among them.
    parameters : tuple of Parameter
        Per-record parameters: the time offset; the clock error, of this record or shared by all; overrides of
        mechanism parameters; the initial states.
    burn_in_s : float
        Initial time in s that is simulated but excluded from the fit.
    stretch_s : float
        Length in s of the stretches into which the record is cut; 0 keeps it whole.
    data : Record or None
        Samples of the file; None if it was not read.
    clock_reference : {"recorder", "driver"}
        The clock taken as true where the driver's clock and the recorder's differ.
    command_files : tuple of Path
        Files with the command's instants or phase values.
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
    command_files: tuple[Path, ...] = ()

    def __repr__(self) -> str:
        state = "planned" if self.data is None and self.file is None else repr(self.data) if self.data else "not read"
        return f"<CampaignRecord {self.name} ({self.use}): {state}>"

    @property
    def estimated(self) -> tuple[Match, ...]:
        """The channels that are fitted."""
        return tuple(match for match in self.matches if match.use == "estimate")

    @property
    def leading(self) -> str:
        """The quantity of the first channel that is fitted."""
        return self.estimated[0].quantity

    @property
    def overrides(self) -> tuple[Parameter, ...]:
        """Per-record overrides of mechanism parameters, as ``record.<name>.transducer.gain``."""
        return tuple(q for q in self.parameters if q.replaces)

    @property
    def start(self) -> tuple[Parameter, ...]:
        """Initial states, as ``record.<name>.start.angle``; empty if the record starts at rest."""
        return tuple(q for q in self.parameters if is_of_start(q))

    @property
    def time_offset(self) -> Parameter:
        """Record time in s at which the command starts."""
        return next(q for q in self.parameters if q.declaration.key == TIME_OFFSET.key)

    @property
    def clock(self) -> Parameter | None:
        """Clock error in ppm, positive if the driver's clock is faster than the recorder's; None if not declared."""
        return next((q for q in self.parameters if q.declaration.key == CLOCK.key), None)

    def with_known_values(self, values: Mapping[str, float]) -> CampaignRecord:
        """Set per-record parameters to known values, given by dotted name."""
        parameters = (
            replace(q, value=values[q.name], status=Status.KNOWN) if q.name in values else q for q in self.parameters
        )
        return replace(self, parameters=tuple(parameters))

    @property
    def timing(self) -> Timing:
        """Map from record time to command time, at the values of the file."""
        return Timing(self.time_offset.value, self.clock.value if self.clock else 0.0, self.clock_reference)


@dataclass(frozen=True)
class Stage:
    """One stage of the search, as requested by the user.

    Parameters
    ----------
    records : tuple of str
        Names of the records to fit.
    window_s : (float, float) or None
        Start and end of the fitted window in s of record time; None fits the whole records.
    free : tuple of str
        Dotted names of the parameters to estimate.
    """

    records: tuple[str, ...]
    window_s: tuple[float, float] | None
    free: tuple[str, ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class InCode:
    """Inputs of a campaign made in code, without files.

    Parameters
    ----------
    entries : mapping
        Content of the equivalent campaign.toml.
    samples : mapping of str to SampleColumns
        Samples of the measured records, by record name.
    """

    entries: Mapping[str, Any]
    samples: Mapping[str, SampleColumns]


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Campaign:
    """Records of one mechanism, with the mechanism and the stages of its fit.

    Parameters
    ----------
    path, mechanism_path : Path
        The files they were read from.
    mechanism : Mechanism
    records : tuple of CampaignRecord
        In the order of the file.
    mounting : Mounting or None
        Mounting of the mechanism on a multi-component measuring table.
    stages : tuple of Stage
        Empty if mechid plans them.
    options : IdentifyOptions
    considered : tuple of str
        Names of the effects that a diagnosis considers; empty for all.
    test : DeclaredTest
        Statements on the test, for its report.
    warnings : tuple of str
        One line for each suspicious but usable input.
    synthetic : bool
        Whether the records were simulated instead of measured; every result repeats it.
    source : InCode or None
        Inputs of a campaign made in code; None if it was read from files.
    clock_reference : {"recorder", "driver"} or None
        The clock taken as true; None if not declared.
    """

    path: Path
    mechanism_path: Path
    mechanism: Mechanism
    records: tuple[CampaignRecord, ...]
    mounting: Mounting | None = None
    stages: tuple[Stage, ...] = ()
    options: IdentifyOptions = field(default_factory=IdentifyOptions)
    considered: tuple[str, ...] = ()
    test: DeclaredTest = field(default_factory=DeclaredTest)
    warnings: tuple[str, ...] = ()
    synthetic: bool = False
    source: InCode | None = None
    clock_reference: ClockReference | None = None

    def __repr__(self) -> str:
        names = ", ".join(record.name for record in self.records)
        return f"<Campaign {self.path}: {len(self.free)} free parameters, records {names}>"

    def record(self, name: str) -> CampaignRecord:
        """Return the record of this name; UsageError if there is none."""
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
        """Parameters by dotted name: those of the mechanism, then those of each record."""
        return parameters_of(self.mechanism, self.records)

    @property
    def free(self) -> tuple[Parameter, ...]:
        """Parameters to be estimated, including per-record ones."""
        return tuple(q for q in self.parameters.values() if q.is_free)


def parameters_of(mechanism: Mechanism, records: tuple[CampaignRecord, ...]) -> dict[str, Parameter]:
    """Return all parameters by dotted name."""
    own = {q.name: q for record in records for q in record.parameters}
    return {**mechanism.parameters, **own}


def key_in_record(record_parameter: str) -> str:
    """Return the name of a per-record parameter without the prefix of its record.

    Examples
    --------
    >>> key_in_record("record.full_46.transducer.gain")
    'transducer.gain'
    """
    return record_parameter.split(".", 2)[2]


def is_of_start(parameter: Parameter) -> bool:
    """Return whether a per-record parameter is an initial state."""
    return parameter.declaration.key.startswith(f"{START}.")


def is_start_name(name: str) -> bool:
    """Return whether a dotted name denotes an initial state of a record.

    Examples
    --------
    >>> is_start_name("record.full_46.start.angle"), is_start_name("load.start_rate")
    (True, False)
    """
    return name.startswith("record.") and key_in_record(name).startswith(f"{START}.")


def record_parameter_name(record: str, key: str) -> str:
    """Return the dotted name of a per-record parameter."""
    return f"record.{record}.{key}"
