"""Fleets whose truth is known: finished fits written by hand, the values of each unit drawn with known scatter."""

import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from estimates import free, known, write

NAMES = ("stepper.coil_resistance", "stepper.torque_constant", "friction.viscous", "gear.stiffness", "gear.damping")
MEANS = dict(zip(NAMES, (9.9, 0.384, 0.0061, 913.0, 0.39), strict=True))


@dataclass(frozen=True)
class Truth:
    """What units are drawn from; `spread`, `error`, and `slopes` for each of a covariate, are shares of the mean."""

    means: dict = field(default_factory=lambda: dict(MEANS))
    spread: float = 0.02
    error: float = 0.005
    slopes: dict = field(default_factory=dict)

    def unit(self, rng):
        """Draw the true values of a unit."""
        return {n: m * (1.0 + self.spread * rng.standard_normal()) for n, m in self.means.items()}

    def estimated(self, unit, rng, x=0.0):
        """Draw the estimates of a unit at a covariate, as in estimate.json; their errors vary by a factor of 4."""
        out = {}
        for name, value in unit.items():
            sigma = self.error * self.means[name] * 2.0 ** rng.uniform(-1.0, 1.0)
            there = value + self.slopes.get(name, 0.0) * self.means[name] * x
            out[name] = free(there + sigma * rng.standard_normal(), sigma, "1")
        return out


def write_fit(folder: Path, parameters, **options):
    """Write a finished fit and return its folder."""
    return write(folder, {}, {**parameters, "gear.ratio": known(50.0, "1")}, **options)


def write_fleet_file(folder: Path, entries, head=""):
    """Write fleet.toml of entries, mappings of keys to values as TOML writes them, and return it."""
    tables = ("[[campaign]]\n" + "".join(f"{k} = {v}\n" for k, v in entry.items()) for entry in entries)
    path = folder / "fleet.toml"
    path.write_text(head + "\n" + "\n".join(tables), encoding="utf-8")
    return path


def quoted(text):
    """Return a text as TOML writes it."""
    return json.dumps(text)


def drawn(folder: Path, units: int, seed: int, truth: Truth | None = None):
    """Write the fits of some units and return their folders."""
    truth, rng = truth or Truth(), np.random.default_rng(seed)
    return [write_fit(folder / f"FM{k:02d}", truth.estimated(truth.unit(rng), rng)) for k in range(units)]
