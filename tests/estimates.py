"""estimate.json files written by hand, every number known, for the tests of comparisons."""

import json
from pathlib import Path

from whole_estimate import whole_estimate

STEPPING = {"stepping": "full", "microsteps": 1, "start_angle_deg": 45.0, "waveform": "cosine", "start": "commanded"}


def record(rms, *, use="estimate", samples=10_000, effective=None, used=None, digest="ab" * 32, **command):
    """Return a record's table; `effective` samples are all where they are not given."""
    channel = {
        "unit": "N*m",
        "samples": samples,
        "samples_sha256": digest,
        "residual_rms": rms,
        "fit_percent": None if rms is None else 90.0,
        "effective_samples": effective or (rms and samples),
        "orders": [],
    }
    return {
        "use": use,
        "samples": used or samples,
        "offset": 0.01,
        "drift": 0.0,
        "validation": {"command": STEPPING | command, "judged_from_s": None, "channels": {"torque": channel}},
    }


def free(value, std_error, unit="N m/rad"):
    """Return an estimated parameter's table."""
    return {"value": value, "unit": unit, "std_error": std_error, "status": "free"}


def known(value, unit="N m/rad"):
    """Return a known parameter's table."""
    return {"value": value, "unit": unit, "std_error": None, "status": "known"}


def write(folder: Path, records, parameters, outcome="converged", plant="p", grade="A"):
    """Write an estimate.json into a folder and return the folder."""
    content = {
        "format": "mechid-estimate/1",
        "grade": grade,
        "grade_reasons": [],
        "outcome": {"code": outcome, "message": ""},
        "parameters": parameters,
        "records": records,
        "provenance": {"plant": plant},
    }
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "estimate.json").write_text(json.dumps(whole_estimate(content)))
    return folder


BOTH = {"gear.stiffness": free(913.0, 0.5), "gear.damping": free(0.39, 0.001)}
ONE = {"gear.stiffness": free(914.0, 0.4), "gear.damping": known(0.48)}
"""Parameters of two hypotheses: both free, and one of them."""
