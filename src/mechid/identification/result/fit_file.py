"""A fit read back from its estimate.json and the campaign it was made of."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from mechid.campaign import Campaign
from mechid.errors import InputFileError
from mechid.identification.output_error.declaration import Reading
from mechid.identification.output_error.identity import file_digest
from mechid.identification.result.channel_fit import ChannelFit
from mechid.identification.result.consistency import Consistency
from mechid.identification.result.estimate_file import is_synthetic, read_estimate
from mechid.identification.result.fit import Fit, RecordFit, StageReport
from mechid.identification.result.grade import Grade, Reason
from mechid.identification.result.missing import Missing, Suggested
from mechid.identification.result.nuisance import Nuisance
from mechid.identification.result.outcome import FitOutcome
from mechid.identification.result.parameter_estimate import ParameterEstimate, PriorShare
from mechid.identification.result.terms_beside import TermsBeside

ESTIMATED = (
    "use",
    "samples",
    "fit_percent",
    "residual_rms",
    "noise_sigma",
    "offset",
    "drift",
    "horizon_s",
    "prefilter_order",
    "rejected",
)
STAGE = ("name", "records", "cost", "evaluations", "seconds", "note")
PARAMETER = (
    "symbol",
    "unit",
    "value",
    "std_error",
    "std_error_white",
    "start",
    "min",
    "max",
    "status",
    "reason",
    "local_only",
    "std_error_noise",
    "dof",
    "contradicted",
)
NUMBERS = ("fit_percent", "residual_rms", "noise_sigma", "horizon_s", "cost")
"""Entries of which null means that there is no such number."""


def read_fit(path: Path | str, campaign: Campaign) -> Fit:
    """Return the fit that an estimate.json holds.

    Parameters
    ----------
    path : Path
    campaign : Campaign
        The one that was identified, its records read.

    Raises
    ------
    InputFileError
        The file is missing or damaged, or a file of the campaign is no longer the one that was identified.
    """
    content = read_estimate(path)
    try:
        _refuse_changed(content["provenance"]["inputs_sha256"], campaign, Path(path))
        fit = _fit(content, campaign)
        fit.to_dict()  # what cannot be written again is no fit
        return fit
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        what = " ".join(str(error).split()) or type(error).__name__
        raise InputFileError(f"{path}: is damaged at {what}; identify anew") from error


def _fit(content: Mapping[str, Any], campaign: Campaign) -> Fit:
    parameters = {
        name: ParameterEstimate(
            name=name,
            prior=PriorShare(**p["prior"]) if p["prior"] else None,
            at_physical_limit=bool(p.get("at_physical_limit")),
            one_sided=tuple(p["ci95"]) if p["ci95"] and p["std_error"] is None else None,
            std_error_clock=p.get("std_error_clock"),  # absent from files of earlier versions
            **_kept(p, PARAMETER),
        )
        for name, p in content["parameters"].items()
    }
    own = campaign.mechanism.parameters
    values = {name: p.value for name, p in parameters.items() if name in own and own[name].is_free}
    names, matrix = content["correlation"]["names"], content["correlation"]["matrix"]
    records = {
        name: RecordFit(
            name=name,
            channels=_channels(r["channels"]),
            taken=Reading.from_dict(r["taken"]),
            nuisance=Nuisance.from_dict(r["nuisance"]) if r.get("nuisance") else None,
            **_kept(r, ESTIMATED),
        )
        for name, r in content["records"].items()
    }
    return Fit(
        mechanism=campaign.mechanism.with_values(values),
        parameters=parameters,
        correlation_names=tuple(names),
        correlation=_square(matrix, len(names)),
        covariance=_square(content["covariance"]["matrix"], len(names)),
        records=records,
        stages=tuple(StageReport(free=tuple(s["free"]), **_kept(s, STAGE)) for s in content["stages"]),
        outcome=FitOutcome[str(content["outcome"]["code"]).upper()],
        warnings=tuple(content["warnings"]),
        notes=tuple(content["notes"]),
        provenance=content["provenance"],
        consistency=Consistency.from_dict(content["consistency"]) if content["consistency"] else None,
        grade=Grade(content["grade"]),
        reasons=tuple(map(Reason.from_dict, content["grade_reasons"])),
        mains_hz=content.get("mains_hz"),
        missing=tuple(map(Missing.from_dict, content.get("missing", ()))),
        beside=TermsBeside.from_dict(content["beside"]) if content.get("beside") else None,
        suggested=tuple(Suggested(**one) for one in content.get("suggested", ())),
        completed=tuple(content["completed"]) if content.get("completed") is not None else None,
        synthetic=is_synthetic(content) or campaign.synthetic,
    )


def _channels(entries: Mapping[str, Any]) -> dict[str, ChannelFit]:
    return {quantity: _channel(_kept(own, tuple(own))) for quantity, own in entries.items()}


def _channel(own: Mapping[str, Any]) -> ChannelFit:
    runs = tuple((int(first), int(stop)) for first, stop in own["rejected_runs"])
    lines = tuple((float(hz), float(amplitude), float(phase)) for hz, amplitude, phase in own.get("lines", ()))
    return ChannelFit(**{**own, "rejected_runs": runs, "lines": lines})


def _kept(entries: Mapping[str, Any], keys: tuple[str, ...]) -> dict[str, Any]:
    return {k: math.nan if entries[k] is None and k in NUMBERS else entries[k] for k in keys}


def _square(matrix: list[list[float | None]], size: int) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.array(matrix, dtype=np.float64).reshape(size, size)


def _refuse_changed(digests: Mapping[str, str], campaign: Campaign, path: Path) -> None:
    """Compare the files as they are with those that were identified; samples in memory by their own digest."""
    files = [(file, file_digest(file)) for file in (campaign.path, campaign.mechanism_path)]
    read = [r.data for r in campaign.records if r.data is not None]
    for file, found in [*files, *((data.path, file_digest(data.path) or data.digest) for data in read)]:
        if digests.get(file.name, "") != found:
            raise InputFileError(f"{path}: {file} is not the file that was identified; identify anew")
