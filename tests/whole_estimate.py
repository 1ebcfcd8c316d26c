"""Entries of estimate.json that a test has nothing to say of, so that a fit can be read from what it does say."""

PARAMETER = {
    "symbol": "p",
    "unit": "1",
    "std_error": None,
    "std_error_white": None,
    "std_error_noise": None,
    "ci95": None,
    "start": 0.0,
    "min": None,
    "max": None,
    "reason": "",
    "local_only": False,
    "prior": None,
    "dof": None,
    "contradicted": False,
}
RECORD = {
    "fit_percent": 90.0,
    "residual_rms": 1e-3,
    "noise_sigma": 1e-3,
    "offset": None,
    "drift": None,
    "horizon_s": 1.0,
    "prefilter_order": 0,
    "rejected": 0,
    "channels": {},
    "taken": {},
}
FIT = {
    "grade": "A",
    "grade_reasons": [],
    "consistency": None,
    "records": {},
    "stages": [],
    "warnings": [],
    "notes": [],
    "provenance": {},
}


def whole_estimate(content):
    """Return the content of an estimate.json with every entry that a fit has."""
    no_matrix = {"names": [], "matrix": []}
    correlation = content.get("correlation", no_matrix)
    return {
        **FIT,
        "correlation": correlation,
        "covariance": {"names": correlation["names"], "matrix": correlation["matrix"]},
        **content,
        "parameters": {name: PARAMETER | p for name, p in content["parameters"].items()},
        "records": {name: RECORD | r for name, r in content.get("records", {}).items()},
    }
