"""Emission of a campaign against its requirements: verdicts, lines, spectra."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.budgets.prediction import Prediction
from mechid.campaign.declared_test import DeclaredTest
from mechid.display import DisplayedResult
from mechid.emissions.emission_line import EmissionLine
from mechid.emissions.predicted import PredictedEmission, decide
from mechid.emissions.trust import BenchUse
from mechid.records import ChannelSpec
from mechid.specification.requirement import Requirement
from mechid.specification.verdict import Judged, Verdict


@dataclass(frozen=True, kw_only=True, eq=False)
class EmissionSpectrum:
    """Largest amplitude and density of groups of bins of one direction at one rate, (G,) each; peak values and SI.

    `rms` is the root mean square over all bins that can be judged.
    """

    record: str
    rate: float
    direction: str
    unit: str
    bin_hz: float
    frequency_hz: FloatArray
    amplitude: FloatArray
    density: FloatArray
    rms: float = np.nan


@dataclass(frozen=True, kw_only=True)
class AtRate:
    """Verdict on a requirement at one stretch of a record; rate in full steps/s, NaN where it is not known."""

    record: str
    rate: float
    judged: Judged


@dataclass(frozen=True, kw_only=True, eq=False)
class Assessment:
    """One requirement with its verdict, and the verdicts at all rates that lead to it.

    Attributes
    ----------
    requirement : Requirement
    judged : Judged
        Of the records.
    at_rates : tuple of AtRate
    judged_hz : (float, float) or None
    prediction : Prediction or None
        Of the fit.
    decided : Judged or None
        Of records and prediction together; None without a fit.
    """

    requirement: Requirement
    judged: Judged
    at_rates: tuple[AtRate, ...]
    judged_hz: tuple[float, float] | None
    prediction: Prediction | None = None
    decided: Judged | None = None

    @property
    def deciding(self) -> Judged:
        """What decides: the records, with a fit both together."""
        return self.decided or self.judged

    @property
    def verdict(self) -> Verdict:
        """Verdict over all rates."""
        return self.deciding.verdict


@dataclass(frozen=True, kw_only=True)
class SourceFile:
    """A record or a background that was judged: its file, digest, length and rates in full steps/s.

    `command` is in words, `started` the date and time of its first sample (ISO 8601); empty where not known.
    """

    name: str
    file: str
    sha256: str
    state: str
    sample_rate_hz: float
    duration_s: float
    rates: tuple[float, ...]
    command: str = ""
    started: str = ""
    channels: tuple[ChannelSpec, ...] = ()


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Emission(DisplayedResult):
    """Emission of a campaign against its requirements.

    Attributes
    ----------
    assessments : tuple of Assessment
        One for each requirement.
    lines : tuple of EmissionLine
    spectra, backgrounds : tuple of EmissionSpectrum
        Of the records; of the backgrounds that were subtracted.
    usable_hz : (float, float)
        Frequencies in Hz that all records could be judged at.
    bands_hz : mapping of str to (float, float)
        Frequencies in Hz that each direction could be judged at in all records.
    bench : BenchUse
        What was made of the channels of the bench, and up to which frequency they can be trusted.
    notes : tuple of str
        What was left out, subtracted or assumed.
    sources : tuple of SourceFile
    synthetic : bool
        Whether the records were simulated.
    predicted : PredictedEmission or None
        By the fit, at rates that were tested or not; None without one.
    test : DeclaredTest
        Statements of the campaign file on the test.
    inputs : mapping of str to str
        SHA-256 of the files of campaign, requirements and masks, by name.
    """

    assessments: tuple[Assessment, ...]
    lines: tuple[EmissionLine, ...]
    spectra: tuple[EmissionSpectrum, ...]
    backgrounds: tuple[EmissionSpectrum, ...]
    usable_hz: tuple[float, float]
    bands_hz: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    bench: BenchUse = field(default_factory=BenchUse)
    notes: tuple[str, ...] = ()
    sources: tuple[SourceFile, ...] = ()
    synthetic: bool = False
    predicted: PredictedEmission | None = None
    test: DeclaredTest = field(default_factory=DeclaredTest)
    inputs: Mapping[str, str] = field(default_factory=dict)

    @property
    def passes(self) -> bool:
        """Whether every requirement is shown to be met."""
        return all(one.verdict is Verdict.PASS for one in self.assessments)


def with_prediction(found: Emission, predicted: PredictedEmission) -> Emission:
    """Return an emission with the predictions of its requirements, and the verdicts on both together."""
    assessments = tuple(
        replace(one, prediction=own, decided=decide(one.judged, own.judged, predicted.place))
        for one, own in zip(found.assessments, predicted.predictions, strict=True)
    )
    notes = (*found.notes, *predicted.notes, *(note for own in predicted.predictions for note in own.notes))
    return replace(found, assessments=assessments, predicted=predicted, notes=notes)
