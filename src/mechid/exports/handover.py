"""Handover of a finished fit to an export: mechanism, covariance, and commands for the verification."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from functools import cached_property
from importlib.metadata import version
from typing import Any

import numpy as np

from mechid.analysis.fit_residuals import FitResiduals, is_simulated
from mechid.arrays import FloatArray
from mechid.campaign import Campaign
from mechid.campaign.prediction import time_base
from mechid.command import Command, MeasuredCommand
from mechid.display import SYNTHETIC
from mechid.errors import FitError
from mechid.exports.stand import describe_mechanism
from mechid.identification.result.estimate_file import DIGEST
from mechid.identification.result.finished_fit import error_covariance, refuse_failed
from mechid.identification.result.fit import Fit
from mechid.identification.result.grade import GRADE_WORDS
from mechid.plant.mechanism import Mechanism
from mechid.simulation.simulator import TimeBase

NAME = "mechanism"
"""Name of the model if that of the campaign's folder is not valid for every target."""


@dataclass(frozen=True)
class Trial:
    """Command and time base of a record, for the comparison of an export with mechid."""

    name: str
    command: Command
    base: TimeBase


@dataclass(frozen=True, eq=False)
class Handover:
    """Input of every target.

    Attributes
    ----------
    name : str
        Name of the model: a letter, then letters, digits and underscores.
    mechanism : Mechanism
        Mechanism with the estimated values.
    fit : Fit
    names : tuple of str, (n,)
        Parameters with a standard error.
    covariance : (n, n)
        Their covariance in the units of the mechanism file, valid under model error.
    trials : tuple of Trial
        Commands of the step-driven records, in the order of the campaign.
    stands : str
        Sentence that describes the mechanism: as in flight or as on the bench.
    """

    name: str
    mechanism: Mechanism
    fit: Fit
    names: tuple[str, ...]
    covariance: FloatArray
    trials: tuple[Trial, ...]
    stands: str = ""

    @cached_property
    def residuals(self) -> FitResiduals | None:
        """Residuals of the fit; None if it has neither a folder nor its campaign."""
        return FitResiduals(self.fit) if self.fit.folder or self.fit.campaign else None

    @property
    def trust(self) -> str:
        """Reliability of the values, in one or two sentences."""
        reasons = [reason.text for reason in self.fit.reasons]
        return " ".join([*([SYNTHETIC] if self.is_synthetic else []), GRADE_WORDS[self.fit.grade], *reasons])

    @cached_property
    def is_synthetic(self) -> bool:
        """Whether the records were simulated, according to the fit or its report."""
        return is_simulated(self.fit)

    @property
    def provenance(self) -> dict[str, Any]:
        """Origin of the values: version, grade of the fit and its inputs."""
        own = self.fit.provenance
        kept = {key: own[key] for key in ("versions", "inputs_sha256", DIGEST, "plant", "seed") if key in own}
        return {
            "mechid": version("mechid"),
            "mechanism": self.stands,
            "grade": str(self.fit.grade),
            "trust": self.trust,
            "fit": kept,
        }

    def std_error(self, name: str) -> float | None:
        """Return the standard error of a parameter in its unit; None if it has none."""
        return float(np.sqrt(self.covariance[(k := self.names.index(name)), k])) if name in self.names else None


def handover(fit: Fit, campaign: Campaign | None, *, anyway: bool = False) -> Handover:
    """Make the handover of a fit.

    Parameters
    ----------
    fit : Fit
    campaign : Campaign or None
        Campaign of the fit; None leaves no commands for the verification.
    anyway : bool
        Whether to accept a failed fit.

    Raises
    ------
    FitError
        The fit has failed.
    """
    if not anyway:
        refuse_failed(fit, FitError, "Identify anew, or hand it on with --anyway")
    # A folder contains the residuals; without one they are computed from the campaign.
    if fit.folder is None:
        fit = replace(fit, campaign=campaign or fit.campaign)
    names, covariance = error_covariance(fit)
    return Handover(
        name=_name(campaign),
        mechanism=fit.mechanism,
        fit=fit,
        names=names,
        covariance=covariance,
        trials=_trials(campaign) if campaign else (),
        stands=describe_mechanism(fit.mechanism, {}, stand=False),
    )


def _name(campaign: Campaign | None) -> str:
    # Names of models have to be identifiers in C and in FMI.
    own = re.sub(r"\W+", "_", campaign.path.resolve().parent.name, flags=re.ASCII).strip("_") if campaign else ""
    return own if re.match(r"[A-Za-z]", own) else NAME


def _trials(campaign: Campaign) -> tuple[Trial, ...]:
    """Return the step-driven records; those driven by measured channels cannot be commanded in other tools."""
    return tuple(
        Trial(record.name, record.command, time_base(record, campaign))
        for record in campaign.records
        if not isinstance(record.command, MeasuredCommand)
    )
