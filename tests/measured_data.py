"""Measured data by others, outside the repository: where they are, and the figures reached on them."""

import os
from dataclasses import dataclass
from pathlib import Path

import pytest

NAMED = "MECHID_DATA"
PARTS = (
    "EMPS",
    "cogging",
    "craig_bampton",
    "formats",
    "gear_robot",
    "harmonic_friction_map_harivin",
    "nist_strd",
    "pendulum",
    "stepper_accel",
    "stepper_encoder",
    "stepper_slit_resolver_ecmc",
    "torque_ripple",
)


def data_folder():
    """Return the folder that MECHID_DATA names, whole; without that variable the test is skipped."""
    if not os.environ.get(NAMED):
        pytest.skip(f"no measured data: set {NAMED} to their folder")
    folder = Path(os.environ[NAMED]).resolve()
    missing = [part for part in PARTS if not (folder / part).is_dir()]
    assert not missing, f"{NAMED} names {folder}, which lacks {', '.join(missing)}"
    return folder


@dataclass(frozen=True)
class Figure:
    """A number reached on measured data, and the range in which it is asked for."""

    what: str
    reached: float
    least: float
    most: float
    unit: str

    @property
    def is_met(self):
        return self.least <= self.reached <= self.most

    def __str__(self):
        if self.least == -float("inf"):
            target = f"at most {self.most:.6g}"
        elif self.most == float("inf"):
            target = f"at least {self.least:.6g}"
        else:
            target = f"{self.least:.6g} to {self.most:.6g}"
        end = f" {self.unit}" if self.unit else ""
        return f"{'met   ' if self.is_met else 'MISSED'} {self.what}: {self.reached:.6g}{end}, target {target}{end}"
