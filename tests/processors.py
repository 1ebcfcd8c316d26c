"""The same fit by kernels compiled for several processors: their sums round differently, what is found may not.

An emulated processor is one whose instructions this one has too: fused products and wide vectors are what differs.
"""

import json
import os
import platform
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

HASWELL = "+sse3,+ssse3,+sse4.1,+sse4.2,+popcnt,+avx,+avx2,+fma,+bmi,+bmi2,+lzcnt,+movbe,+f16c"
PROCESSORS = {
    "native": {},
    "haswell": {"NUMBA_CPU_NAME": "haswell", "NUMBA_CPU_FEATURES": HASWELL},
    "generic": {"NUMBA_CPU_NAME": "generic"},
}
"""What Numba is told by the name of a processor: this one, one without 512-bit vectors, one without fused products."""
MOST_SIGMAS = 0.1
"""By how much a value may differ between processors, in the smaller of its standard errors."""
PROGRAM = Path(__file__).with_name("one_fit.py")


def fits(what: str, folder: Path) -> dict[str, dict]:
    """Return what `one_fit.py` finds by the name of each processor; each has a cache of kernels of its own."""
    if platform.machine() not in ("x86_64", "AMD64"):
        pytest.skip("the processors that are emulated are of the x86-64 family")
    return {name: _fit(what, folder / name, told) for name, told in PROCESSORS.items()}


def _fit(what: str, cache: Path, told: Mapping[str, str]) -> dict:
    plain = {key: value for key, value in os.environ.items() if not key.startswith("NUMBA_CPU")}
    environment = {**plain, **told, "MECHID_CACHE": str(cache), "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    done = subprocess.run(
        [sys.executable, str(PROGRAM), what], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    found: dict = json.loads(done.stdout)
    return found


def differences(found: Mapping[str, dict]) -> Iterator[str]:
    """Yield a line for each thing in which the fits of other processors are not that of this one."""
    here = found["native"]
    for name, there in found.items():
        if there["outcome"] != here["outcome"]:
            yield f"{name}: outcome {there['outcome']}, here {here['outcome']}"
        for parameter, a in here["parameters"].items():
            b = there["parameters"][parameter]
            if a["status"] != b["status"]:
                yield f"{name}: {parameter} is {b['status']}, here {a['status']}"
            elif a["std_error"] and b["std_error"]:
                apart = abs(a["value"] - b["value"])
                apart = min(apart, 360.0 - apart) if a["unit"] == "deg" else apart
                sigmas = apart / min(a["std_error"], b["std_error"])
                if not sigmas <= MOST_SIGMAS:
                    yield f"{name}: {parameter} {b['value']:.9g}, here {a['value']:.9g}: {sigmas:.2g} sigma apart"
