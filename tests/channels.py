"""Campaigns whose records have several channels: the paper's mechanism run by the slow twin, noise added."""

import numpy as np

from freed import freed
from mechid.campaign import load_campaign, mechanism_text
from paper import constant
from runs import base, run_twin

NOISE = {"torque": 2e-3, "current_phase_a": 3e-3, "current_phase_b": 3e-3, "output_angle": 2e-6}
OFFSET = {"torque": 0.01, "current_phase_a": 5e-3, "current_phase_b": -4e-3, "output_angle": 0.3}
UNIT = {"torque": "Nm", "current_phase_a": "A", "current_phase_b": "A", "output_angle": "rad"}
COMMANDS = {"full_5": (5.0, 1), "full_46": (46.0, 1)}
FREE = (
    "stepper.coil_resistance",
    "stepper.coil_inductance",
    "stepper.torque_constant",
    "gear.stiffness",
    "gear.damping",
    "friction.viscous",
)


def written(
    folder,
    m,
    truth,
    *,
    quantities=tuple(NOISE),
    keys=lambda quantity: "",
    more="",
    change=lambda y, quantity: None,
    seed=31,
    seconds=0.3,
):
    """Write a campaign whose records have several channels, with three stages.

    `keys` adds to a channel's table, `more` to a record's, `change` its samples in place.
    """
    rng, time_base = np.random.default_rng(seed), base(seconds)
    plant = m.plant.with_outputs(quantities)
    lines = ['mechanism = "mechanism.toml"']
    for name, (rate, microsteps) in COMMANDS.items():
        y = run_twin(type(m)(plant, m.parameters, m.options), constant(rate, microsteps=microsteps), time_base).y
        columns = [time_base.times]
        for k, quantity in enumerate(quantities):
            columns.append(y[:, k] + OFFSET[quantity] + rng.normal(0.0, NOISE[quantity], len(y)))
            change(columns[-1], quantity)
        header = ",".join(["time_s", *(f"{quantity}_{UNIT[quantity]}" for quantity in quantities)])
        np.savetxt(folder / f"{name}.csv", np.stack(columns, axis=1), delimiter=",", header=header, comments="")
        entries = ", ".join(f'{{ quantity = "{q}", column = {k}{keys(q)} }}' for k, q in enumerate(quantities, 1))
        lines += [
            "[[record]]",
            f'name = "{name}"',
            f'file = "{name}.csv"',
            f"channels = [{entries}]",
            more,
            f'command = {{ stepping = "full", rate = {rate}, start_angle_deg = 45.0 }}',
        ]
    names = ", ".join(f'"{name}"' for name in truth)
    for window in ("window_s = [0.0, 0.03]", "window_s = [0.0, 0.1]", ""):
        lines += ["[[stage]]", window, f"free = [{names}]"]
    (folder / "campaign.toml").write_text("\n".join(lines) + "\n")
    (folder / "mechanism.toml").write_text(freed(mechanism_text(m), truth, off=1.01))
    return load_campaign(folder)
