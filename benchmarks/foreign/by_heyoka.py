"""Records by heyoka, run in whichever Python has it."""

import json
import math
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from foreign.benches import RATE_HZ, Command
from foreign.values import VALUES
from incomplete.stepping import edges

SIDE = Path(__file__).with_name("heyoka_side.py")
MISSING = "has no heyoka: install it there (the package is named heyoka), or name another Python by --python"


def version(python: str) -> str:
    """Return the version of heyoka in a Python; SystemExit where there is none."""
    asked = subprocess.run(
        [python, "-c", "import heyoka; print(heyoka.__version__)"], capture_output=True, text=True, check=False
    )
    if asked.returncode:
        raise SystemExit(f"{python}: {MISSING}")
    return asked.stdout.strip()


def torque_of(python: str, command: Command, seconds: float) -> np.ndarray:
    """Return the torque of a test run, a sample every 1/RATE_HZ s, N m."""
    instants, voltages = edges(command, 1.01 * seconds)
    asked = {
        "values": json.dumps(dict(VALUES)),
        "edges": instants,
        "voltages": voltages,
        "angle": math.radians(command.get("start_angle_deg", 0.0)),
        "interval": 1.0 / RATE_HZ,
        "samples": round(seconds * RATE_HZ) + 1,
    }
    with tempfile.TemporaryDirectory() as folder:
        run, out = Path(folder, "run.npz"), Path(folder, "out.npz")
        np.savez(run, **asked)
        subprocess.run([python, str(SIDE), str(run), str(out)], check=True)
        return np.load(out)["torque"]
