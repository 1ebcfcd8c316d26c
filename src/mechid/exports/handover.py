"""Hand-over of a finished fit: its mechanism, covariance, and the commands it is checked with."""

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
from mechid.errors import FitError
from mechid.exports.stand import which_mechanism
from mechid.identification.result.as_fitted import error_covariance, refuse_failed
from mechid.identification.result.estimate_file import DIGEST
from mechid.identification.result.fit import Fit
from mechid.identification.result.grade import GRADE_WORDS
from mechid.plant.mechanism import Mechanism
from mechid.shown import SYNTHETIC
from mechid.simulation.simulator import TimeBase

NAME = "mechanism"
"""Of the model where the campaign's folder has no name that every target takes."""


@dataclass(frozen=True)
class Trial:
    """A record's command and time base, under which what is written is held against mechid."""

    name: str
    command: Command
    base: TimeBase


@dataclass(frozen=True, eq=False)
class Handover:
    """What every target is made of.

    Attributes
    ----------
    name : str
        Of the model: a letter, then letters, digits and underscores.
    mechanism : Mechanism
        With the estimated values.
    fit : Fit
    names : tuple of str, (n,)
        Parameters that have a standard error.
    covariance : (n, n)
        Of them, in the mechanism file's units: the one that holds under model error.
    trials : tuple of Trial
        Of the records that a command drives, in the campaign's order.
    stands : str
        Which mechanism is handed on, as it flies or as on the bench, in a sentence.
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
        """Residuals of the fit; None of one that has neither a folder nor its campaign."""
        return FitResiduals(self.fit) if self.fit.folder or self.fit.campaign else None

    @property
    def trust(self) -> str:
        """How far the values can be trusted, in a sentence or two."""
        reasons = [reason.text for reason in self.fit.reasons]
        return " ".join([*([SYNTHETIC] if self.is_synthetic else []), GRADE_WORDS[self.fit.grade], *reasons])

    @cached_property
    def is_synthetic(self) -> bool:
        """Whether the records were simulated, as the fit or the report beside it says."""
        return is_simulated(self.fit)

    @property
    def provenance(self) -> dict[str, Any]:
        """Where the values come from: version, the fit's grade and what it says of its own inputs."""
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
        """Return the standard error of a parameter in its unit; None where it has none."""
        return float(np.sqrt(self.covariance[(k := self.names.index(name)), k])) if name in self.names else None


def handover(fit: Fit, campaign: Campaign | None, *, anyway: bool = False) -> Handover:
    """Return what a fit hands on.

    Parameters
    ----------
    fit : Fit
    campaign : Campaign or None
        Of which it was identified; None leaves nothing to try it with.
    anyway : bool
        Whether a fit that failed is handed on too.

    Raises
    ------
    FitError
        The fit has failed.
    """
    if not anyway:
        refuse_failed(fit, FitError, "Identify anew, or hand it on with --anyway")
    if fit.folder is None:  # its residuals are computed from the campaign; a folder holds them
        fit = replace(fit, campaign=campaign or fit.campaign)
    names, covariance = error_covariance(fit)
    return Handover(
        name=_name(campaign),
        mechanism=fit.mechanism,
        fit=fit,
        names=names,
        covariance=covariance,
        trials=_trials(campaign) if campaign else (),
        stands=which_mechanism(fit.mechanism, {}, stand=False),
    )


def _name(campaign: Campaign | None) -> str:
    own = re.sub(r"\W+", "_", campaign.path.resolve().parent.name, flags=re.ASCII).strip("_") if campaign else ""
    return own if re.match(r"[A-Za-z]", own) else NAME


def _trials(campaign: Campaign) -> tuple[Trial, ...]:
    """Return the records that steps drive; what a measured channel drives cannot be commanded elsewhere."""
    return tuple(
        Trial(record.name, record.command, time_base(record, campaign))
        for record in campaign.records
        if not isinstance(record.command, MeasuredCommand)
    )
