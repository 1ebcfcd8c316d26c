"""Campaigns whose model lacks nothing, written as files: the library's blocks, run by the kernel, noise added.

Beside the records lies a catalogue: each free value is some fifth off, up and down in turn, in bounds of half and
twice the truth. There are no stages.
"""

import copy
import shutil
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import cycle
from pathlib import Path

import numpy as np

from mechid.campaign import Campaign, load_campaign, mechanism_from_table, mechanism_text
from mechid.campaign.prediction import simulate
from mechid.command import InputChannel, MeasuredCommand
from mechid.plant.mechanism import Mechanism
from runs import base, run_kernel

OWN_BLOCKS = Path(__file__).resolve().parents[1] / "examples" / "own_block"
RATE_HZ, AXIS_HZ = 10_000.0, 1000.0
SUBSTEPS = 8
"""Integration steps a sample of what makes the records."""
OFF = (1.2, 0.85)
NOISE = {"torque": 2e-3, "rotor_angle": 1e-4, "output_angle": 2e-6, "current_phase_b": 3e-3, "position": 2e-5}
DELAY = "time_offset_s"
RUNS = {
    "full_5": 'stepping = "full", rate = 5.0, start_angle_deg = 45.0',
    "full_46": 'stepping = "full", rate = 46.0, start_angle_deg = 45.0',
    "micro_46": 'stepping = "micro", microsteps = 16, rate = 46.0',
}
"""Commands by the name of their record."""
Disturbance = Callable[[np.ndarray, np.random.Generator], np.ndarray]


@dataclass(frozen=True, kw_only=True)
class Bench:
    """The mechanism that makes the records, what is free of it, what is commanded and measured.

    Attributes
    ----------
    seed : int
        Of its noise.
    table : mapping
        Its mechanism file.
    free : tuple of str
        Dotted names of what the catalogue does not know.
    own : mapping of record to {name: value}
        What each record has of its own, free in the catalogue.
    commands : mapping of str to str
        Commands by the name of their record, each for `seconds`.
    sigma : mapping of str to float
        Standard deviations of priors, in the file's units.
    options : str
        Text for the campaign file's ``[identify]``.
    disturbed : callable
        Makes of a channel's samples, and the generator of its noise, what is recorded besides.
    """

    seed: int
    table: Mapping
    free: tuple[str, ...]
    commands: Mapping[str, str] = field(default_factory=lambda: RUNS)
    seconds: float = 0.6
    quantities: tuple[str, ...] = ("torque",)
    own: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    sigma: Mapping[str, float] = field(default_factory=dict)
    options: str = ""
    disturbed: Disturbance = lambda y, rng: y

    @property
    def mechanism(self) -> Mechanism:
        """The truth; a block that is none of the library's is one of the tutorial."""
        return mechanism_from_table(self.table, "mechanism.toml", OWN_BLOCKS)

    @property
    def truth(self) -> dict[str, float]:
        """The true values of all that is free, by dotted name."""
        mechanism = self.mechanism
        own = {f"record.{record}.{name}": v for record, values in self.own.items() for name, v in values.items()}
        return {name: mechanism.value(name) for name in self.free} | own


def written(folder: Path, bench: Bench) -> Campaign:
    """Write the campaign of a bench, and read it."""
    rng = np.random.default_rng(bench.seed)
    for path in OWN_BLOCKS.glob("*.py"):
        shutil.copy(path, folder)
    (folder / "mechanism.toml").write_text(catalogue(bench))
    (folder / "campaign.toml").write_text("\n".join(_lines(bench)) + "\n")
    made_by = _made_by(bench, load_campaign(folder, read_records=False, need_files=False))
    for name in bench.commands:
        run = simulate(made_by, name, sample_rate_hz=RATE_HZ, duration_s=bench.seconds, substeps=SUBSTEPS)
        measured = [bench.disturbed(noisy(run.values[q], q, rng), rng) for q in bench.quantities]
        _save(folder / f"{name}.csv", run.time, *measured)
    return load_campaign(folder)


def noisy(y: np.ndarray, quantity: str, rng: np.random.Generator) -> np.ndarray:
    """Return samples with white noise and an offset of five times its size."""
    return y + NOISE[quantity] * (rng.standard_normal(y.size) + 5.0 * rng.standard_normal())


def catalogue(bench: Bench) -> str:
    """Return the mechanism file from which the bench is identified."""
    table, truth = copy.deepcopy(dict(bench.table)), bench.mechanism
    for name, off in zip(bench.free, cycle(OFF)):
        *path, key = [int(part) if part.isdigit() else part for part in name.split(".")]
        owner = table
        for part in path:
            owner = owner[part]
        prior = {"sigma": bench.sigma[name]} if name in bench.sigma else {}
        owner[key] = _around(truth.value(name), off) | prior
    return mechanism_text(mechanism_from_table(table, "mechanism.toml", OWN_BLOCKS))


def _around(value: float, off: float) -> dict[str, float]:
    low, high = sorted((0.5 * value, 2.0 * value))
    return {"value": off * value, "min": low, "max": high}


def _made_by(bench: Bench, campaign: Campaign) -> Campaign:
    """Return the campaign with the true values, those of its records included."""
    truth = bench.truth
    records = tuple(
        replace(r, parameters=tuple(q.at_value(truth.get(q.name, q.value)) for q in r.parameters))
        for r in campaign.records
    )
    mechanism = campaign.mechanism.with_values({name: truth[name] for name in bench.free})
    return replace(campaign, mechanism=mechanism, records=records)


def _lines(bench: Bench) -> Iterator[str]:
    yield from ('mechanism = "mechanism.toml"', "[identify]", bench.options)
    entries = ", ".join(f'{{ quantity = "{q}", column = {k} }}' for k, q in enumerate(bench.quantities, 1))
    for name, command in bench.commands.items():
        yield from ("[[record]]", f'name = "{name}"', f'file = "{name}.csv"', f"channels = [{entries}]")
        yield f"command = {{ {command} }}"
        yield from _own_lines(bench.own.get(name, {}))


def _own_lines(values: Mapping[str, float]) -> Iterator[str]:
    stand = {name: value for name, value in values.items() if name != DELAY}
    if DELAY in values:
        yield f"{DELAY} = {{ value = 0.0, min = -1e-3, max = 1e-3 }}"
    if stand:
        entries = (f"{name} = {_inline(_around(value, 1.1))}" for name, value in stand.items())
        yield f"test_stand = {{ {', '.join(entries)} }}"


def _inline(entry: Mapping[str, float]) -> str:
    return f"{{ {', '.join(f'{key} = {value!r}' for key, value in entry.items())} }}"


def driven(folder: Path, bench: Bench, *, pull: str, size: float, seconds: float = 4.0) -> Campaign:
    """Write the campaign of a mechanism under a measured force or torque of two sines, and read it."""
    rng, time_base = np.random.default_rng(bench.seed), base(seconds, rate_hz=AXIS_HZ)
    t, (moved,) = time_base.times, bench.quantities
    u = size * (0.05 + np.sin(2 * np.pi * 0.7 * t) + 0.8 * np.sin(2 * np.pi * 2.3 * t + 1.0))
    command = MeasuredCommand().driven_by((InputChannel(quantity=pull, samples=u),), AXIS_HZ, 0.0)
    m = replace(bench.mechanism, plant=bench.mechanism.plant.with_outputs(bench.quantities))
    y = run_kernel(m, command, time_base, substeps=SUBSTEPS).values[moved]
    _save(folder / "run.csv", t, noisy(y, moved, rng), u)
    channels = f'{{ quantity = "{moved}", column = 1 }}, {{ quantity = "{pull}", column = 2, role = "input" }}'
    (folder / "mechanism.toml").write_text(catalogue(bench))
    (folder / "campaign.toml").write_text(
        f'mechanism = "mechanism.toml"\n[[record]]\nname = "run"\nfile = "run.csv"\nchannels = [{channels}]\n'
    )
    return load_campaign(folder)


def _save(path: Path, *columns: np.ndarray) -> None:
    header = ",".join(["time_s", *(f"channel_{k}" for k in range(1, len(columns)))])
    np.savetxt(path, np.stack(columns, axis=1), fmt="%.17g", delimiter=",", header=header, comments="")
