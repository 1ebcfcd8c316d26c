"""An estimate.json with the paper's values, as tests of the budget need it; its sigmas are made up."""

import json

import numpy as np

from paper import ESTIMATED

FREE = (
    "stepper.coil_resistance", "stepper.coil_inductance", "stepper.torque_constant", "stepper.detent.0.amplitude",
    "stepper.detent.1.amplitude", "friction.coulomb", "friction.viscous", "gear.stiffness", "gear.damping",
    "housing.gain",
)  # fmt: skip
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
        "outcome": {"code": "converged", "message": ""},
        "parameters": parameters,
        "correlation": {"names": list(FREE), "matrix": correlation.tolist()},
        "records": {"sweep": record | {"fit_percent": fit_percent}},
    }


def write_estimate_of_paper(folder, **options):
    """Write it as estimate.json and return its path."""
    path = folder / "estimate.json"
    path.write_text(json.dumps(estimate(**options)), encoding="utf-8")
    return path
