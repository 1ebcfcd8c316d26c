"""Identify a mechanism from Python: read a campaign, fit it, print it, and lay the model over a record.

    python examples/identify_from_python.py FOLDER

FOLDER holds campaign.toml; `mechid demo` makes one, `mechid new` one to fill in.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import mechid


def main(folder: Path) -> mechid.Fit:
    """Identify the campaign in a folder and print what was found."""
    campaign = mechid.load_campaign(folder)
    fit = mechid.identify(campaign)
    print(fit.outcome.value)
    for name, parameter in fit.parameters.items():
        if parameter.std_error is not None:
            print(f"{name:28s} {parameter.value:12.6g} +- {parameter.std_error:.2g} {parameter.unit}")
    for warning in fit.warnings:
        print(f"warning: {warning}")

    first = fit.records[campaign.records[0].name]
    model = mechid.simulate(replace(campaign, mechanism=fit.mechanism), first.name)
    largest = abs(model.torque).max()
    print(f"{first.name}: fit {first.fit_percent:.2f} %, largest modelled torque {largest:.3g} N m")
    return fit


if __name__ == "__main__":
    main(Path(sys.argv[1]))
