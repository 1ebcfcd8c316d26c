"""Print the fit of one campaign as JSON: a program for a process whose kernels are compiled for another processor.

`python one_fit.py FOLDER` takes a campaign; `python one_fit.py NAME` one of the complete fits, without a folder.
"""

import json
import sys
import tempfile
from pathlib import Path

from complete_fits import CASES
from mechid.campaign import load_campaign
from mechid.identification.identify import identify


def fitted(what: str) -> dict:
    """Return status, value and standard error of each parameter that is estimated, and the outcome."""
    with tempfile.TemporaryDirectory() as empty:
        campaign = CASES[what].campaign(Path(empty)) if what in CASES else load_campaign(what)
        fit = identify(campaign, workers=1)
    parameters = {
        name: {"value": q.value, "std_error": q.std_error, "unit": q.unit, "status": q.status}
        for name, q in fit.parameters.items()
        if q.status not in ("known", "tied")
    }
    return {"outcome": fit.outcome.code, "parameters": parameters}


if __name__ == "__main__":
    json.dump(fitted(sys.argv[1]), sys.stdout)
