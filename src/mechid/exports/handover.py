"""Hand-over of a finished fit: its mechanism, covariance, and the commands it is checked with."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.budgets.discrepancy import report_of
from mechid.campaign import Campaign
from mechid.campaign.prediction import time_base
from mechid.command import Command, MeasuredCommand
from mechid.errors import FitError
from mechid.exports.stand import which_mechanism
from mechid.identification.result.estimate_file import SYNTHETIC, is_synthetic
from mechid.identification.result.estimated_mechanism import DIGEST
from mechid.identification.result.grade import GRADE_WORDS, Grade
from mechid.plant.mechanism import Mechanism
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
    names : tuple of str, (n,)
        Parameters that have a standard error.
    covariance : (n, n)
        Of them, in the mechanism file's units: the one that holds under model error.
    estimate : mapping
        What estimate.json holds.
    trials : tuple of Trial
        Of the records that a command drives, in the campaign's order.
    folder : Path or None
        Where identify left the estimate, with what its records have left; None where that is not known.
    stands : str
        Which mechanism is handed on, as it flies or as on the bench, in a sentence.
    """

    name: str
    mechanism: Mechanism
    names: tuple[str, ...]
    covariance: FloatArray
    estimate: Mapping[str, Any]
    trials: tuple[Trial, ...]
    folder: Path | None = None
    stands: str = ""

    @property
    def grade(self) -> Grade:
        """What the fit is worth."""
        return Grade(self.estimate["grade"])

    @property
    def trust(self) -> str:
        """How far the values can be trusted, in a sentence or two."""
        reasons = [str(reason["text"]) for reason in self.estimate.get("grade_reasons", [])]
        return " ".join([*([SYNTHETIC] if self.is_synthetic else []), GRADE_WORDS[self.grade], *reasons])

    @property
    def is_synthetic(self) -> bool:
        """Whether the records were simulated, as far as the estimate or the report beside it says so."""
        if is_synthetic(self.estimate):
            return True
        return self.folder is not None and bool(report_of(self.estimate, self.folder).get("synthetic"))

    @property
    def provenance(self) -> dict[str, Any]:
        """Where the values come from: version, the fit's grade and what it says of its own inputs."""
        own = self.estimate.get("provenance", {})
        kept = {key: own[key] for key in ("versions", "inputs_sha256", DIGEST, "plant", "seed") if key in own}
        return {
            "mechid": version("mechid"),
            "mechanism": self.stands,
            "grade": str(self.grade),
            "trust": self.trust,
            "fit": kept,
        }

    def std_error(self, name: str) -> float | None:
        """Return the standard error of a parameter in its unit; None where it has none."""
        return float(np.sqrt(self.covariance[(k := self.names.index(name)), k])) if name in self.names else None


def handover(
    estimate: Mapping[str, Any],
    mechanism: Mechanism,
    campaign: Campaign | None,
    *,
    anyway: bool = False,
    folder: Path | None = None,
) -> Handover:
    """Return what a fit hands on.

    Parameters
    ----------
    estimate : mapping
        What estimate.json holds.
    mechanism : Mechanism
        That which was identified, with the estimated values.
    campaign : Campaign or None
        Of which it was identified; None leaves nothing to try it with.
    anyway : bool
        Whether a fit that failed is handed on too.
    folder : Path or None
        Where identify left the estimate.

    Raises
    ------
    FitError
        The fit has failed.
    """
    if estimate.get("grade", Grade.FAILED) == Grade.FAILED and not anyway:
        said = estimate["outcome"]["message"]
        raise FitError(f"{GRADE_WORDS[Grade.FAILED]} {said} Identify anew, or hand it on with --anyway")
    names, covariance = _covariance(estimate)
    return Handover(
        name=_name(campaign),
        mechanism=mechanism,
        names=names,
        covariance=covariance,
        estimate=estimate,
        trials=_trials(campaign) if campaign else (),
        folder=folder,
        stands=which_mechanism(mechanism, {}, stand=False),
    )


def _name(campaign: Campaign | None) -> str:
    own = re.sub(r"\W+", "_", campaign.path.resolve().parent.name, flags=re.ASCII).strip("_") if campaign else ""
    return own if re.match(r"[A-Za-z]", own) else NAME


def _covariance(estimate: Mapping[str, Any]) -> tuple[tuple[str, ...], FloatArray]:
    """Return the parameters that have a standard error, and their covariance by the errors under model error."""
    everything = estimate["correlation"]["names"]
    matrix = np.array(estimate["correlation"]["matrix"], dtype=np.float64).reshape(len(everything), len(everything))
    errors = np.array([estimate["parameters"][name]["std_error"] for name in everything], dtype=np.float64)
    known = np.flatnonzero(np.isfinite(errors) & np.all(np.isfinite(np.diag(matrix)[:, None]), axis=1))
    return tuple(everything[k] for k in known), (matrix * np.outer(errors, errors))[np.ix_(known, known)]


def _trials(campaign: Campaign) -> tuple[Trial, ...]:
    """Return the records that steps drive; what a measured channel drives cannot be commanded elsewhere."""
    return tuple(
        Trial(record.name, record.command, time_base(record, campaign))
        for record in campaign.records
        if not isinstance(record.command, MeasuredCommand)
    )
