"""Whether error bars hold on measured axes: the first half of a record against its second half.

Each campaign of examples/measured/ that one record makes up is fitted whole, then with the samples of its first half
alone and with those of its second half alone, both simulated from the record's beginning. z is the difference of two
estimates over the root of the sum of their squared standard errors.

    MECHID_DATA=FOLDER python benchmarks/measured_halves.py [emps pendulum robot_axis]
"""

import os
import shutil
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from mechid.campaign import Campaign, Stage, load_campaign
from mechid.identification.identify import identify
from mechid.identification.result.fit import Fit

EXAMPLES = Path(__file__).resolve().parents[1] / "examples" / "measured"
NAMES = ("emps", "pendulum", "robot_axis")


def main() -> None:
    """Fit each campaign whole and in halves, and print how far the halves agree."""
    for name in sys.argv[1:] or NAMES:
        with tempfile.TemporaryDirectory() as folder:
            campaign = copied(name, Path(folder))
            whole = identify(campaign, workers=1)
            halves = [identify(half(campaign, whole, k), workers=1) for k in (0, 1)]
        print(f"{name}: whole {told(whole)}; halves {' and '.join(map(told, halves))}")
        for what in ("std_error", "std_error_noise"):
            z = apart(*halves, what)
            worst = ", ".join(f"{n} {v:.2f}" for n, v in z.items())
            print(f"  {what}: RMS z {np.sqrt(np.mean(np.square(list(z.values())))):.2f}: {worst}")


def copied(name: str, folder: Path) -> Campaign:
    """Return an example's campaign with its data beside it."""
    shutil.copytree(EXAMPLES / name, folder / name, ignore=shutil.ignore_patterns("data"))
    (folder / name / "data").symlink_to(Path(os.environ["MECHID_DATA"]).resolve(), target_is_directory=True)
    return load_campaign(folder / name)


def half(campaign: Campaign, whole: Fit, k: int) -> Campaign:
    """Return a campaign that starts at the whole record's values and counts one half of its samples."""
    (record,) = campaign.estimated
    first, last = record.data.time_start_s, record.data.time_start_s + record.data.samples / record.data.sample_rate_hz
    middle = 0.5 * (first + last)
    free = tuple(p.name for p in whole.parameters.values() if p.status == "free")
    window = (first, middle) if k == 0 else (middle, last)
    stage = Stage(records=(record.name,), window_s=window, free=free)
    return replace(campaign, mechanism=whole.mechanism, stages=(stage,))


def told(fit: Fit) -> str:
    """Return what a fit says of the agreement of its parts."""
    c = fit.consistency
    tests = {"phase": c.phase, "record": c.record, "time": c.time} if c else {}
    said = ", ".join(f"{k} F {t.ratio:.2f} z {t.z:.1f}" for k, t in tests.items() if t)
    return f"{fit.outcome.code} ({said})"


def apart(a: Fit, b: Fit, what: str) -> dict[str, float]:
    """Return the differences of two fits in their standard errors, by parameter."""
    found = {}
    for name, p in a.parameters.items():
        q = b.parameters[name]
        if p.status == q.status == "free":
            found[name] = (p.value - q.value) / float(np.hypot(getattr(p, what), getattr(q, what)))
    return found


if __name__ == "__main__":
    main()
