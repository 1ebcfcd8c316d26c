"""Findings about misread records, and the declared records that detectors examine."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property

from mechid.campaign import Campaign, CampaignRecord
from mechid.command import Command
from mechid.identification.output_error.declaration import Reading, rate_entry
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target
from mechid.identification.readings.spectrum import RecordSpectrum, has_readable_spectrum, spectrum_of
from mechid.units import to_si_factor


class Confidence(Enum):
    """Evidence for a finding."""

    CONFIRMED = "confirmed"
    """A fit of the records supports this cause alone."""
    AMBIGUOUS = "ambiguous"
    """Another cause fits about as well."""
    OBSERVED = "observed"
    """The records show it by themselves; no other cause was compared."""


@dataclass(frozen=True)
class Finding:
    """A record, or all of them, that contradicts its declaration.

    Attributes
    ----------
    records : tuple of str
        Names of the records; empty where all of them are concerned alike.
    cause : str
        Kind of misreading, in one or two words.
    text : str
        Evidence in the records.
    remedy : str
        Advice to the user; empty where there is none.
    confidence : Confidence
    reading : mapping of record to Reading
        Proposed reading of the records; empty where no single reading is proposed. `identify` applies it where the
        finding is confirmed.
    parameter : str
        The parameter of the mechanism file that is wrong instead, by dotted name; empty where none is.
    """

    records: tuple[str, ...]
    cause: str
    text: str
    remedy: str = ""
    confidence: Confidence = Confidence.OBSERVED
    reading: Mapping[str, Reading] = field(default_factory=dict)
    parameter: str = ""

    @property
    def is_confirmed(self) -> bool:
        """Whether a fit of the records supports this cause alone."""
        return self.confidence is Confidence.CONFIRMED

    def line(self, *, used: bool = False) -> str:
        """Return the finding as one line; `used` marks a reading that was applied."""
        names = (" and " if len(self.records) == 2 else ", ").join(self.records)
        where = f"record{'s' * (len(self.records) > 1)} {names}" if names else "all records"
        return f"{where}: {self.text}{' (read so in this fit)' * used}{'; ' * bool(self.remedy)}{self.remedy}"


@dataclass(frozen=True, eq=False)
class DeclaredRecords:
    """The records of a campaign as declared, before any search.

    Attributes
    ----------
    campaign : Campaign
    problem : Problem
        All records to be fitted.
    seed : int
        Seed of the starting points.
    before_search : bool
        Whether a search of the same records follows, which handles disturbances by itself.
    """

    campaign: Campaign
    problem: Problem
    seed: int = 0
    before_search: bool = False

    @cached_property
    def spectra(self) -> dict[str, RecordSpectrum]:
        """Spectra of the records whose torque under a command can be read."""
        return {t.name: spectrum_of(t) for t in self.problem.targets if has_readable_spectrum(t)}

    @property
    def readable(self) -> list[Target]:
        """The records with a readable spectrum."""
        return [spectrum.whole for spectrum in self.spectra.values()]

    def unit_factor(self, name: str) -> float:
        """Return the factor from the numbers of a record's leading channel to its SI unit."""
        record = self.campaign.record(name)
        return record.data.channel(record.leading).scale if record.data is not None else 1.0


Detector = Callable[[DeclaredRecords, Sequence[Finding]], Iterable[Finding]]
"""Function that examines the declared records, given the findings of the detectors before it."""


def misread_names(findings: Iterable[Finding]) -> frozenset[str]:
    """Return the names of single records that have another reading, or that no reading explains."""
    return frozenset(
        name for one in findings if one.reading or one.cause == UNEXPLAINED for name in (*one.records, *one.reading)
    )


UNEXPLAINED = "unexplained"
"""Cause of a finding about a record that contradicts its declaration and fits no other reading either."""


TORQUE_UNITS = ("N*m", "mN*m", "N*cm", "uN*m", "kN*m", "gf*cm", "kgf*cm", "kgf*m", "ozf*in", "lbf*in", "lbf*ft")
"""Units in which torque is recorded."""
SAME_UNIT = 1e-6
"""Relative distance of a factor from a unit's: far above the rounding of products of decimals."""


def reading_words(record: CampaignRecord, reading: Reading) -> tuple[str, str]:
    """Describe the changes of a reading relative to the declaration, and the entries to write for it."""
    changes, remedies = [], []
    if reading.polarity < 0:
        quantity = record.leading.replace("_", " ")
        changes.append(f"its {quantity} of the other sign (polarity -1, declared +1)")
        remedies.append(f"the other sign of its {quantity} channel's gain (gain = -1.0 where there is none)")
    if reading.direction < 0:
        changes.append("its commanded rate of the other sign")
        remedies.append("the other sign of its rate")
    if reading.scale != 1.0:
        changes.append(f"torque times {reading.scale:g}")
        remedies.append(unit_remedy(record, reading.scale))
    if reading.stepping is not None:
        changes.append(
            f"{_stepping_entry(reading.stepping, reading.microsteps)} "
            f"(declared {_stepping_entry(record.command.stepping, record.command.microsteps)})"
        )
        remedies.append(_stepping_entry(reading.stepping, reading.microsteps))
    if reading.rate is not None:
        entry = ", ".join(f"{key} = {_format_rate(value)}" for key, value in rate_entry(reading.rate).items())
        changes.append(f"{entry} full steps/s (declared {_declared_rate(record.command)})")
        remedies.append(entry)
    if reading.start_angle_deg is not None:
        changes.append(
            f"a start angle of {reading.start_angle_deg:g} deg (declared {record.command.start_angle_deg:g})"
        )
        remedies.append(f"start_angle_deg = {reading.start_angle_deg:g}")
    if reading.time_offset_s is not None:
        value, least, most = reading.time_offset_s
        changes.append(f"a time offset of about {value:.4g} s (declared {record.time_offset.value:g}), now estimated")
        remedies.append(f"time_offset_s = {{ value = {value:.4g}, min = {least:.4g}, max = {most:.4g} }}")
    return " and ".join(changes), " and ".join(remedies)


def unit_remedy(record: CampaignRecord, scale: float) -> str:
    """Return the entry to write for a torque channel whose samples have to be multiplied by a scale."""
    assert record.data is not None
    factor = record.data.channel(record.leading).scale * scale
    unit = next((u for u in TORQUE_UNITS if abs(to_si_factor(u, "torque") / factor - 1.0) < SAME_UNIT), "")
    return f'unit = "{unit}" in its torque channel' if unit else f"{scale:g} times the gain of its torque channel"


def _stepping_entry(stepping: str, microsteps: int | None) -> str:
    """Return the entry of a stepping in a campaign file."""
    own = f", microsteps = {microsteps}" if stepping == "micro" else ""
    return f'stepping = "{stepping}"{own}'


def _declared_rate(command: Command) -> str:
    return ", ".join(f"{value}" for value in rate_entry(command.rate).values())


def _format_rate(value: object) -> str:
    """Format a rate, or the points of a profile, to five digits."""
    if isinstance(value, list):
        return "[" + ", ".join(_format_rate(one) for one in value) + "]"
    return f"{value:.5g}"
