"""Origin of a budget: the test of the fit that flies, its records with their digests, and the files that were read."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from importlib.metadata import version
from typing import Any

from mechid.identification.result.estimate_file import DIGEST
from mechid.identification.result.fit import Fit


def origin_of(fit: Fit) -> dict[str, Any]:
    """Return what a fit holds of its test: declared statements, records with digests and noise, versions.

    Fits of earlier versions hold less; what they lack is empty.
    """
    known = fit.provenance.get("records")
    files: Mapping[str, Any] = known if isinstance(known, Mapping) else {}
    return {
        "test": fit.provenance.get("test") or {},
        "records": [
            {
                "name": name,
                "use": record.use,
                "file": files.get(name, {}).get("file", ""),
                "sha256": files.get(name, {}).get("sha256", ""),
                "started": files.get(name, {}).get("start_time") or "",
                "duration_s": files.get(name, {}).get("duration_s"),
                "sample_rate_hz": files.get(name, {}).get("sample_rate_hz"),
                "noise_sigma": record.noise_known,
                "noise_rests_on": record.noise_rests_on,
            }
            for name, record in fit.records.items()
        ],
        "grade": str(fit.grade),
        "versions": fit.provenance.get("versions") or {},
        "inputs_sha256": fit.inputs_sha256 or {},
    }


def origin_numbers(origin: Mapping[str, Any], digest: str, inputs: Mapping[str, str]) -> dict[str, Any]:
    """Return the tables ``fit`` and ``provenance`` of budget.json.

    Parameters
    ----------
    origin : mapping
        Of `origin_of`.
    digest : str
        SHA-256 of the mechanism file of the fit; empty if unknown.
    inputs : mapping of str to str
        SHA-256 of the files of the budget, by name.
    """
    return {
        "fit": dict(origin),
        "provenance": {
            "fit": {DIGEST: digest or None},
            "versions": {"mechid": version("mechid"), "python": platform.python_version()},
            "inputs_sha256": dict(inputs),
        },
    }
