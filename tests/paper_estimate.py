"""What identify leaves, with the paper's values, as tests of the budget need it; its sigmas are made up."""

import hashlib
import json

import numpy as np

from layouts import changed, mechanism_of, paper_table
from mechid.campaign import mechanism_text
from paper import ESTIMATED
from whole_estimate import whole_estimate

FREE = (
    "stepper.coil_resistance",
    "stepper.coil_inductance",
    "stepper.torque_constant",
    "stepper.detent.0.amplitude",
    "stepper.detent.1.amplitude",
    "friction.coulomb",
    "friction.viscous",
    "gear.stiffness",
    "gear.damping",
    "housing.gain",
)
RELATIVE = 0.005


def estimate(fit_percent=100.0, relative=RELATIVE):
    """Return the content; every free parameter has the relative sigma, R and k_m correlate by 0.9."""
    parameters = {}
    for name, value in ESTIMATED.items():
        status = "free" if name in FREE else "tied" if name == "stepper.back_emf_constant" else "known"
        sigma = abs(value) * relative if status == "free" else None
        parameters[name] = {"value": value, "std_error": sigma, "status": status}
    correlation = np.eye(len(FREE))
    correlation[0, 2] = correlation[2, 0] = 0.9
    record = {
        "use": "validate",
        "samples": 10_000,
        "fit_percent": fit_percent,
        "residual_rms": 1e-3,
        "noise_sigma": 0.0,
    }
    return {
        "format": "mechid-estimate/1",
        "grade": "A",
        "grade_reasons": [],
        "outcome": {"code": "converged", "message": ""},
        "parameters": parameters,
        "correlation": {"names": list(FREE), "matrix": correlation.tolist()},
        "records": {"sweep": record | {"fit_percent": fit_percent}},
    }


def write_estimate_of_paper(folder, **options):
    """Write it as estimate.json, with its mechanism beside it, and return its path."""
    table = changed(paper_table(), {"stepper": {"back_emf_constant": None}})
    return write_estimate(folder, mechanism_of(table), estimate(**options))


def write_estimate(folder, mechanism, content):
    """Write a mechanism and the content of an estimate beside it, signed as by identify; return the estimate's path."""
    text = mechanism_text(mechanism)
    (folder / "mechanism.toml").write_text(text, encoding="utf-8")
    own = {
        "mechanism_file": "mechanism.toml",
        "mechanism_sha256": hashlib.sha256(text.encode()).hexdigest(),
        "quantities": [*mechanism.plant.outputs],
        "plant": mechanism.plant.digest,
    }
    content["provenance"] = {**content.get("provenance", {}), **own}
    path = folder / "estimate.json"
    path.write_text(json.dumps(whole_estimate(content)), encoding="utf-8")
    return path


def estimate_of(mechanism, free, relative=RELATIVE):
    """Return the content of an estimate of any mechanism; each of `free` has the relative sigma, none correlate."""
    parameters = {
        name: {
            "value": mechanism.value(name),
            "std_error": abs(mechanism.value(name)) * relative if name in free else None,
            "status": "free" if name in free else "known",
        }
        for name in [*mechanism.parameters, *(name for name in free if name not in mechanism.parameters)]
        if name in mechanism.parameters
    }
    return {
        "format": "mechid-estimate/1",
        "grade": "A",
        "grade_reasons": [],
        "outcome": {"code": "converged", "message": ""},
        "parameters": parameters,
        "correlation": {"names": list(free), "matrix": np.eye(len(free)).tolist()},
        "records": {},
    }
