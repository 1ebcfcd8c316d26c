"""Result files of an identification."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from mechid.analysis.components_file import FILE_NAME as COMPONENTS_NAME
from mechid.analysis.components_file import components_content
from mechid.analysis.residual_file import FILE_NAME as RESIDUAL_NAME
from mechid.analysis.residual_file import residual_content
from mechid.analysis.validation import RecordValidation, with_validation
from mechid.campaign import mechanism_text
from mechid.errors import InputFileError
from mechid.identification.result.estimate_file import json_text, sign_provenance
from mechid.identification.result.fit import ESTIMATE_NAME, Fit
from mechid.identification.result.grade import grade_words
from mechid.reading.whole import read_result
from mechid.reports.added_effects import added_comment, added_notes
from mechid.writing import write_atomically, write_together

REPORT_NAME = "report.json"
MECHANISM_NAME = "mechanism.toml"
ESTIMATED = "Estimated by mechid"
"""In the first lines of a mechanism file that `estimated_text` has made."""


def write_results(
    fit: Fit,
    data: Mapping[str, Any],
    folder: Path | str,
    *,
    mechanism_name: str = MECHANISM_NAME,
    validation: Mapping[str, RecordValidation] | None = None,
) -> list[Path]:
    """Write estimate.json, report.json, residual.json and the mechanism with the estimated values.

    If a record has components besides its torque, components.json is written too. Earlier files are replaced once all
    new ones are complete.

    Parameters
    ----------
    fit : Fit
    data : mapping
        As `report_data` makes it.
    folder : Path
        Made with its parents where it is missing.
    mechanism_name : str
        Name of the mechanism file.
    validation : mapping or None
        Validation of the records, from `validate`; estimate.json holds it under each record, and residual.json holds
        the residuals of their torques.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    UsageError
        The folder cannot be written to.
    """
    fit = replace(fit, synthetic=data["synthetic"])
    # Estimate and report are signed with the digest of this text, so it comes first.
    text = estimated_text(fit)
    fit = sign_provenance(fit, mechanism_name, text)
    texts = {
        mechanism_name: text,
        REPORT_NAME: json_text({**data, "provenance": fit.provenance}),
        ESTIMATE_NAME: json_text(with_validation(fit.to_dict(), validation or {})),
    }
    if validation:
        texts[RESIDUAL_NAME] = json_text(residual_content(fit, validation))
    files = write_together(folder, texts)
    return [*files, *write_components(fit, validation or {}, Path(folder))]


def write_components(fit: Fit, validation: Mapping[str, RecordValidation], folder: Path) -> list[Path]:
    """Write components.json beside an estimate and return its path; an earlier one of records without any goes."""
    path, content = folder / COMPONENTS_NAME, components_content(fit, validation)
    if content is None:
        path.unlink(missing_ok=True)
        return []
    write_atomically(path, json_text(content))
    return [path]


def write_residual(fit: Fit, validation: Mapping[str, RecordValidation], folder: Path) -> Path:
    """Write residual.json beside the estimate of a fit that was read back, and return its path."""
    write_atomically(folder / RESIDUAL_NAME, json_text(residual_content(fit, validation)))
    return folder / RESIDUAL_NAME


def estimated_text(fit: Fit, *, synthetic: bool = False) -> str:
    """Return the text of the mechanism file with the estimated values."""
    lines = [f"{ESTIMATED}; standard errors and all else stand in {ESTIMATE_NAME}."]
    if fit.synthetic or synthetic:
        lines = ["SYNTHETIC: estimated from records that were simulated, not measured.", *lines]
    lines += [grade_words(fit.grade, fit.outcome), *added_comment(fit), fit.outcome.value]
    return mechanism_text(fit.mechanism, "\n".join(lines), added_notes(fit))


def read_truth(folder: Path | str) -> tuple[bool, dict[str, float]]:
    """Return whether the records of a result were synthetic, and the true values where they are known.

    Raises
    ------
    InputFileError
        The folder has no report.json, or a damaged one.
    """
    path = Path(folder) / REPORT_NAME
    try:
        content = json.loads(read_result(path))
        truth = {row["name"]: float(row["truth"]) for row in content["parameters"] if row["truth"] is not None}
        return bool(content["synthetic"]), truth
    except FileNotFoundError as error:
        raise InputFileError(f'{path}: there is no such file; "mechid identify" writes it') from error
    except NotADirectoryError as error:
        raise InputFileError(f"{folder}: is no folder; give the result folder of mechid identify") from error
    except OSError as error:
        raise InputFileError(f"{path}: cannot be read ({error.strerror}); identify anew") from error
    except (ValueError, KeyError, TypeError) as error:
        raise InputFileError(f"{path}: is damaged ({error}); identify anew") from error
