"""Whether error bars hold on a real motor: fits of disjoint windows of one record, pair against pair.

A hybrid stepper is stepped at 10 pulses/s with an encoder on its shaft (examples/measured/stepper). The record is laid
out by a rule that knows no fit: a transient begins at the first sample that moves by 3 counts after 25 ms of rest; a
window is 40 transients that begin within 1 ms of every 100 ms; one that does not is listed as a burst of lost samples,
and the next window begins one transient after it. Each window is fitted on its own, from two starts, and the estimates
of every two windows are compared: z is their difference over the root of the sum of their squared standard errors.

    MECHID_DATA=FOLDER python benchmarks/stepper_windows.py
"""

import os
import shutil
import tempfile
from itertools import combinations
from pathlib import Path

import numpy as np

from mechid.campaign import load_campaign
from mechid.identification.identify import identify
from mechid.identification.result.fit import Fit

EXAMPLE = Path(__file__).resolve().parents[1] / "examples" / "measured" / "stepper"
FILE = "stepper_encoder/single_steps_10pps.npz"
BETWEEN_MS, WITHIN_MS = 100, 1
WINDOW_STEPS = 40
LEAD_MS = 10
"""How long before its first transient a window begins."""
COUNT_RAD = 2.0 * np.pi / 8192
STARTS = (
    {
        "stepper.torque_constant": 0.0502,
        "stepper.detent.0.amplitude": 0.0016,
        "friction.coulomb": 0.0013,
        "friction.viscous": 2.1e-4,
    },
    {
        "stepper.torque_constant": 0.0507,
        "stepper.detent.0.amplitude": 0.0013,
        "friction.coulomb": 0.0023,
        "friction.viscous": 1e-4,
    },
)
"""Each window is fitted from both, and the better fit counts: between them one stick/slip more or less is an optimum
of its own."""
RECORD = """mechanism = "mechanism.toml"
[[record]]
name = "full"
file = "data/{file}"
sample_rate_hz = 1000.0
time_offset_s = {{ value = {offset!r}, min = {least!r}, max = {most!r} }}
command = {{ stepping = "full", rate = 10.0, start_angle_deg = 45.0 }}
conditioning = {{ cumulate = ["rotor_angle"], window_s = [{first!r}, {last!r}] }}
channels = [{{ quantity = "rotor_angle", column = "counts_fullstep", unit = "rad", gain = {gain!r} }}]
"""


def main() -> None:
    """Lay the windows, fit them, and print how far they agree."""
    data = Path(os.environ["MECHID_DATA"])
    counts = np.load(data / FILE)["counts_fullstep"].astype(int)
    begins = transients(counts)
    windows, lost = laid(begins)
    print(f"samples lost near {', '.join(f'{at / 1e3:.2f}' for at in lost)} s")
    print(f"{len(begins)} transients, {len(windows)} windows")
    with tempfile.TemporaryDirectory() as folder:
        fits = [fitted(Path(folder), data, begin) for begin in windows]
    for begin, fit in zip(windows, fits, strict=True):
        print(line(begin, fit))
    for what in ("std_error", "std_error_noise"):
        z = pairs(fits, what)
        within = 100.0 * np.mean(np.abs(z) < 2.0)
        print(
            f"{what}: {len(fits) * (len(fits) - 1) // 2} pairs, {z.size} differences, "
            f"RMS z {np.sqrt(np.mean(z**2)):.2f}, below 2: {within:.1f} %, worst {np.abs(z).max():.1f}"
        )


def transients(counts: np.ndarray) -> np.ndarray:
    """Return the samples at which a transient begins."""
    moving = np.flatnonzero(np.abs(counts) >= 3)
    return moving[np.diff(moving, prepend=-1000) > 25]


def laid(begins: np.ndarray) -> tuple[list[int], list[int]]:
    """Return the first transient of each window, and the transients that do not come when they should."""
    windows, lost, first = [], [], 1
    while first + WINDOW_STEPS < len(begins):
        own = begins[first : first + WINDOW_STEPS + 1]
        off = np.abs(own - own[0] - BETWEEN_MS * np.arange(own.size)) > WITHIN_MS
        if off.any():
            lost.append(int(own[np.argmax(off)]))
            first += int(np.argmax(off)) + 1
        else:
            windows.append(int(own[0]))
            first += WINDOW_STEPS
    return windows, lost


def fitted(folder: Path, data: Path, begin: int) -> Fit:
    """Return the fit of the window that begins with a transient."""
    offset = (begin - BETWEEN_MS) / 1e3 - 1e-3
    text = RECORD.format(
        file=FILE,
        gain=COUNT_RAD,
        offset=offset,
        least=offset - 2e-3,
        most=offset + 2e-3,
        first=(begin - LEAD_MS) / 1e3,
        last=(begin - LEAD_MS + WINDOW_STEPS * BETWEEN_MS - 1) / 1e3,
    )
    own = folder / str(begin)
    own.mkdir()
    (own / "data").symlink_to(data.resolve(), target_is_directory=True)
    shutil.copy(EXAMPLE / "mechanism.toml", own)
    (own / "campaign.toml").write_text(text)
    campaign = load_campaign(own)
    return min(
        (identify(campaign, near=near, workers=1) for near in STARTS), key=lambda f: f.records["full"].residual_rms
    )


def line(begin: int, fit: Fit) -> str:
    """Return a window's values with their errors."""
    free = [p for p in fit.parameters.values() if p.status == "free"]
    values = ", ".join(f"{p.name.split('.')[-1]} {p.value:.5g} +- {p.std_error:.2g}" for p in free)
    found = fit.consistency
    z = f"phase z {found.phase.z:.0f} F {found.phase.ratio:.2f}" if found and found.phase else "not tested"
    left = fit.records["full"].residual_rms / COUNT_RAD
    return f"{begin / 1e3:8.3f} s {fit.outcome.code:10} {left:.2f} counts, {z}: {values}"


def pairs(fits: list[Fit], what: str) -> np.ndarray:
    """Return the differences of the mechanism's parameters between every two fits, in their standard errors."""
    found = []
    for a, b in combinations(fits, 2):
        for name in STARTS[0]:
            p, q = a.parameters[name], b.parameters[name]
            if p.status == q.status == "free":
                found.append((p.value - q.value) / np.hypot(getattr(p, what), getattr(q, what)))
    return np.array(found)


if __name__ == "__main__":
    main()
