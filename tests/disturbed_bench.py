"""Campaigns of three records whose recorder, supplies or mains disturb them, by an independent simulator."""

import numpy as np

from csv_files import write_csv
from incomplete.benches import drawn
from incomplete.recording import NOISE_NM, Run, recorded
from mechid.campaign import load_campaign, mechanism_text

FULL = {"stepping": "full", "rate": 46.0, "start_angle_deg": 45.0}
HALF = {"stepping": "half", "rate": 31.0, "start_angle_deg": 45.0}
MICRO = {"stepping": "micro", "microsteps": 16, "rate": 50.0}
"""At the mains' frequency, which its steps must not be taken for."""
RUNS = {"full": Run(FULL, 0.5), "half": Run(HALF, 0.5), "micro": Run(MICRO, 0.8)}
FREE = ("stepper.coil_resistance", "stepper.torque_constant", "friction.coulomb", "gear.stiffness", "gear.damping")
RECORDER_OFF = 'clock_reference = "driver"'
"""Of the benches whose recorder is off."""


def written(folder, size, *, supplies=(1.0, 1.0, 1.0), seed=5, runs=RUNS, free=FREE, sizes=None, above=RECORDER_OFF):
    """Write a campaign of three records with what the size adds; returns it and the truth of what is free.

    `sizes` has what is added to single records instead, `above` what stands above the records.
    """
    mechanism, _ = drawn("clock", 1)
    mechanism = mechanism.with_free(free)
    (folder / "mechanism.toml").write_text(mechanism_text(mechanism))
    lines, rng = ['mechanism = "mechanism.toml"', above], np.random.default_rng(seed)
    for (name, run), supply in zip(runs.items(), supplies, strict=True):
        true = recorded(
            mechanism.with_values({"stepper.peak_voltage": supply * mechanism.value("stepper.peak_voltage")}),
            (sizes or {}).get(name, size),
            run,
            None,
        )
        y = true.torque_Nm + NOISE_NM * rng.standard_normal(true.time_s.size) + 0.01
        write_csv(folder / f"{name}.csv", "time_s,torque_Nm", true.time_s, y, fmt="%.10g")
        command = ", ".join(f"{key} = {value!r}" for key, value in run.command.items()).replace("'", '"')
        lines += ["[[record]]", f'name = "{name}"', f'file = "{name}.csv"', f"command = {{ {command} }}"]
    (folder / "campaign.toml").write_text("\n".join(lines) + "\n")
    return load_campaign(folder), {p.name: p.value for p in mechanism.free}
