"""A campaign without files: mechanism, commands and samples made in Python, identified, drawn, and left as a report.

    python examples/without_files.py FOLDER

The samples are simulated at a stiffness that the fit does not know; put arrays, DataFrames or Datasets of your own in
their place.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import mechid

STIFFNESS, NOISE_NM, SECONDS = 2000.0, 0.002, 0.25


def main(folder: Path) -> mechid.Fit:
    """Identify samples that are in memory, and leave the report in a folder."""
    command = mechid.make_command("full", rate=46.0, start_angle_deg=45.0)
    believed = mechid.catalogue_mechanism().with_free(("gear.stiffness", "gear.damping"))
    true = believed.with_values({"gear.stiffness": STIFFNESS})
    planned = mechid.make_campaign(true, [mechid.make_record("full_46", command=command)])
    run = mechid.simulate(planned, sample_rate_hz=10_000.0, duration_s=SECONDS)
    torque = run.torque + NOISE_NM * np.random.default_rng(0).standard_normal(run.time.size)

    record = mechid.make_record("full_46", torque, time_s=run.time, command=command)
    campaign = mechid.make_campaign(believed, [record], name="without_files")
    fit = mechid.identify(campaign)
    print(fit)
    fit.plot().figure.savefig(folder / "full_46.png")
    mechid.report(fit, folder, synthetic=True)
    return fit


if __name__ == "__main__":
    main(Path(sys.argv[1]))
