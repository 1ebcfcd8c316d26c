"""Records by heyoka, run in whichever Python has it."""

import json
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from foreign.benches import Run
from foreign.values import VALUES

SIDE = Path(__file__).with_name("heyoka_side.py")
MISSING = "has no heyoka: install it there (the package is named heyoka), or name another Python by --python"


def version(python: str) -> str:
    """Return the version of heyoka in a Python; SystemExit where there is none."""
    asked = subprocess.run([python, "-c", "import heyoka; print(heyoka.__version__)"], capture_output=True, text=True,
                           check=False)  # fmt: skip
    if asked.returncode:
        raise SystemExit(f"{python}: {MISSING}")
    return asked.stdout.strip()


def torque_of(python: str, run: Run) -> np.ndarray:
    """Return the torque of a run, (samples,) N m."""
    with tempfile.TemporaryDirectory() as folder:
        asked, answered = Path(folder, "run.npz"), Path(folder, "out.npz")
        np.savez(asked, values=json.dumps(dict(VALUES)), **run._asdict())
        subprocess.run([python, str(SIDE), str(asked), str(answered)], check=True)
        return np.load(answered)["torque"]
