"""Findings: misreadings of records that are reported, and what a detector examines."""

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
        What the records show.
    remedy : str
        What to write or to look at; empty where nothing can be advised.
    confidence : Confidence
    reading : mapping of record to Reading
        How the records are to be read instead; empty where no single reading is proposed. `identify` reads records so
        where the finding is confirmed.
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
        """Return the finding as one line; `used` says that the records are read so."""
        names = (" and " if len(self.records) == 2 else ", ").join(self.records)
        where = f"record{'s' * (len(self.records) > 1)} {names}" if names else "all records"
        return f"{where}: {self.text}{' (read so in this fit)' * used}{'; ' * bool(self.remedy)}{self.remedy}"


@dataclass(frozen=True, eq=False)
class DeclaredRecords:
    """The records of a campaign as they are declared, before any search.

    Attributes
    ----------
    campaign : Campaign
    problem : Problem
        All records that are to be estimated from.
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
        """The records that have such spectra."""
        return [spectrum.whole for spectrum in self.spectra.values()]

    def unit_factor(self, name: str) -> float:
        """Return the factor from the numbers of a record's leading channel to its SI unit."""
        record = self.campaign.record(name)
        return record.data.channel(record.leading).scale if record.data is not None else 1.0


Detector = Callable[[DeclaredRecords, Sequence[Finding]], Iterable[Finding]]
"""Examines the records as declared, given the findings of the detectors before it."""


def misread_names(findings: Iterable[Finding]) -> frozenset[str]:
    """Return the names of single records that are read otherwise, or that no reading explains."""
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
    """Return what a reading changes beside the declaration, and what to write for it."""
    changes, remedies = [], []
    if reading.polarity < 0:
        what = record.leading.replace("_", " ")
        changes.append(f"its {what} of the other sign (polarity -1, declared +1)")
        remedies.append(f"the other sign of its {what} channel's gain (gain = -1.0 where there is none)")
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
        entry = ", ".join(f"{key} = {_rounded(value)}" for key, value in rate_entry(reading.rate).items())
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
    """Return what to write for a torque whose samples are to be multiplied by a scale."""
    assert record.data is not None
    factor = record.data.channel(record.leading).scale * scale
    unit = next((u for u in TORQUE_UNITS if abs(to_si_factor(u, "torque") / factor - 1.0) < SAME_UNIT), "")
    return f'unit = "{unit}" in its torque channel' if unit else f"{scale:g} times the gain of its torque channel"


def _stepping_entry(stepping: str, microsteps: int | None) -> str:
    """Return a stepping as a campaign file writes it."""
    own = f", microsteps = {microsteps}" if stepping == "micro" else ""
    return f'stepping = "{stepping}"{own}'


def _declared_rate(command: Command) -> str:
    return ", ".join(f"{value}" for value in rate_entry(command.rate).values())


def _rounded(value: object) -> str:
    """Return a rate, or the points of a profile, to five digits."""
    if isinstance(value, list):
        return "[" + ", ".join(_rounded(one) for one in value) + "]"
    return f"{value:.5g}"
