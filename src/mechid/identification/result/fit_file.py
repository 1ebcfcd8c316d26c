"""Reader of a finished fit: its estimate.json, with the campaign or with the mechanism file beside it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from mechid.campaign import Campaign
from mechid.errors import InputFileError
from mechid.identification.output_error.declaration import Reading
from mechid.identification.output_error.digests import file_digest
from mechid.identification.result.estimate_file import (
    ERROR_TABLES,
    is_synthetic,
    read_estimate,
    read_estimated_mechanism,
)
from mechid.identification.result.fit import ESTIMATE_NAME, Fit, StageReport
from mechid.identification.result.grade import Consistency, FitOutcome, Grade, Reason
from mechid.identification.result.missing_effects import AsWritten, Missing, SuggestedEffect
from mechid.identification.result.parameter_estimate import ParameterEstimate, PriorShare
from mechid.identification.result.record_result import ChannelFit, MaskedMoment, Nuisance, RecordFit
from mechid.plant.mechanism import Mechanism


def _keys(kind: type, *others: str) -> tuple[str, ...]:
    """Return the fields of a dataclass that estimate.json stores under the same names, without `others`."""
    return tuple(field.name for field in fields(kind) if field.name not in others)


ESTIMATED = _keys(RecordFit, "name", "channels", "reading", "nuisance", "followed_of_whole", "validation")
STAGE = _keys(StageReport, "free")
PARAMETER = _keys(ParameterEstimate, "name", "prior", "at_physical_limit", "one_sided", "std_error_clock", "added")
NUMBERS = ("fit_percent", "residual_rms", "noise_sigma", "horizon_s", "cost")
"""Entries whose null is read as NaN."""

NOT_READ: Any = None
NEEDED = (*ERROR_TABLES, "records")
"""Required tables of estimate.json."""
BESIDE = "an earlier version graded the model with further terms but wrote the values of the model without them"
"""Fault of an estimate that has the table ``beside``."""


def estimate_path(place: Path | str) -> Path:
    """Return the path of the estimate.json of a result folder, or the path itself where it names the file."""
    place = Path(place)
    return place if place.suffix == ".json" else place / ESTIMATE_NAME


def read_fit(place: Path | str, campaign: Campaign | None = None) -> Fit:
    """Read a finished fit.

    Parameters
    ----------
    place : Path
        Result folder, or its estimate.json.
    campaign : Campaign or None
        The identified campaign with its records. Without it the mechanism is read from the file beside the estimate,
        and no record is read.

    Returns
    -------
    Fit
        Its `folder` is the place from which it was read; it holds the campaign if one is given.

    Raises
    ------
    InputFileError
        If the file is missing or damaged, if a file of the campaign has changed since the identification, or, without
        a campaign, if the mechanism file has.
    """
    path = estimate_path(place)
    content = read_estimate(path, needs=NEEDED)
    if campaign is None or _has_added_terms(content):
        mechanism = read_estimated_mechanism(content.get("provenance"), path)
    else:
        mechanism = campaign.mechanism
    fit = _build_checked(content, path, mechanism, campaign)
    return replace(fit, campaign=campaign, synthetic=fit.synthetic or (campaign is not None and campaign.synthetic))


def read_numbers(place: Path | str) -> Fit:
    """Read the numbers of a finished fit, as `read_fit` does without a campaign, but without its mechanism.

    The mechanism file is read and checked on first use of `Fit.mechanism`. Fits can thus be compared after their
    mechanism files or own blocks have changed.
    """
    path = estimate_path(place)
    return _build_checked(read_estimate(path, needs=NEEDED), path)


def _build_checked(
    content: Mapping[str, Any], path: Path, mechanism: Mechanism | None = None, campaign: Campaign | None = None
) -> Fit:
    """Build the fit from the content of an estimate.json; check the campaign's files against it if one is given."""
    if "grade" not in content:
        raise InputFileError(f"{path.name}: grade: missing; the file is of an earlier version, identify anew")
    if content.get("beside"):
        raise InputFileError(f"{path}: beside: {BESIDE}; identify anew")
    try:
        if campaign is not None:
            _refuse_changed(content["provenance"]["inputs_sha256"], campaign, path)
        fit = _build_fit(content, mechanism, path.parent)
        # A fit that cannot be written again is damaged.
        fit.to_dict()
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        place = " ".join(str(error).split()) or type(error).__name__
        raise InputFileError(f"{path}: is damaged at {place}; identify anew") from error
    return fit


def _has_added_terms(content: Mapping[str, Any]) -> bool:
    """Tell whether the mechanism of an estimate has terms that its campaign's mechanism file lacks."""
    parameters = content.get("parameters")
    entries = parameters.values() if isinstance(parameters, Mapping) else ()
    return any(isinstance(p, Mapping) and bool(p.get("added")) for p in entries)


def _build_fit(content: Mapping[str, Any], mechanism: Mechanism | None, folder: Path) -> Fit:
    """Build the fit from the content of an estimate.json; without a mechanism if none is given."""
    parameters = {
        name: ParameterEstimate(
            name=name,
            prior=PriorShare(**p["prior"]) if p["prior"] else None,
            at_physical_limit=bool(p.get("at_physical_limit")),
            one_sided=tuple(p["ci95"]) if p["ci95"] and p["std_error"] is None else None,
            std_error_clock=p.get("std_error_clock"),  # absent from files of earlier versions
            added=bool(p.get("added")),
            **_select_entries(p, PARAMETER),
        )
        for name, p in content["parameters"].items()
    }
    own = mechanism.parameters if mechanism else {}
    values = {name: p.value for name, p in parameters.items() if name in own and own[name].is_free}
    names, matrix = content["correlation"]["names"], content["correlation"]["matrix"]
    records = {
        name: RecordFit(
            name=name,
            channels={
                quantity: _build_channel(_select_entries(own, tuple(own))) for quantity, own in r["channels"].items()
            },
            reading=Reading.from_dict(r["taken"]),
            nuisance=Nuisance.from_dict(r["nuisance"]) if r.get("nuisance") else None,
            followed_of_whole=r.get("followed_percent"),  # absent from files of earlier versions
            validation=r.get("validation"),
            **_select_entries(r, ESTIMATED),
        )
        for name, r in content["records"].items()
    }
    fit = Fit(
        mechanism=mechanism.with_values(values) if mechanism else NOT_READ,
        parameters=parameters,
        correlation_names=tuple(names),
        correlation=_build_matrix(matrix, len(names)),
        covariance=_build_matrix(content["covariance"]["matrix"], len(names)),
        records=records,
        stages=tuple(StageReport(free=tuple(s["free"]), **_select_entries(s, STAGE)) for s in content["stages"]),
        outcome=FitOutcome[str(content["outcome"]["code"]).upper()],
        warnings=tuple(content["warnings"]),
        notes=tuple(content["notes"]),
        provenance=content["provenance"],
        consistency=Consistency.from_dict(content["consistency"]) if content["consistency"] else None,
        grade=Grade(content["grade"]),
        reasons=tuple(map(Reason.from_dict, content["grade_reasons"])),
        mains_hz=content.get("mains_hz"),
        missing=tuple(map(Missing.from_dict, content.get("missing", ()))),
        as_written=AsWritten.from_dict(content["as_written"]) if content.get("as_written") else None,
        suggested=tuple(SuggestedEffect(**one) for one in content.get("suggested", ())),
        completed=tuple(content["completed"]) if content.get("completed") is not None else None,
        synthetic=is_synthetic(content),
        path=tuple(content["outcome"].get("path", ())),  # absent from files of earlier versions
        folder=folder,
    )
    if mechanism is None:
        # Only an absent attribute reaches `Fit.__getattr__`, which then reads the mechanism file.
        del vars(fit)["mechanism"]
    return fit


def _build_channel(own: Mapping[str, Any]) -> ChannelFit:
    runs = tuple((int(first), int(stop)) for first, stop in own["rejected_runs"])
    lines = tuple((float(hz), float(amplitude), float(phase)) for hz, amplitude, phase in own.get("lines", ()))
    masked = tuple(MaskedMoment(**moment) for moment in own.get("masked", ()))
    return ChannelFit(**{**own, "rejected_runs": runs, "lines": lines, "masked": masked})


def _select_entries(entries: Mapping[str, Any], keys: tuple[str, ...]) -> dict[str, Any]:
    return {k: math.nan if entries[k] is None and k in NUMBERS else entries[k] for k in keys}


def _build_matrix(matrix: list[list[float | None]], size: int) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.array(matrix, dtype=np.float64).reshape(size, size)


def _refuse_changed(digests: Mapping[str, str], campaign: Campaign, path: Path) -> None:
    """Refuse files that differ from those that were identified; samples in memory are compared by their own digest."""
    files = [(file, file_digest(file)) for file in (campaign.path, campaign.mechanism_path)]
    read = [r.data for r in campaign.records if r.data is not None]
    for file, found in [*files, *((data.path, file_digest(data.path) or data.digest) for data in read)]:
        if digests.get(file.name, "") != found:
            raise InputFileError(f"{path}: {file} is not the file that was identified; identify anew")
