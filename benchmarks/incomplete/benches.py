"""Benches written as files: records of a mechanism with one effect, and a mechanism file that lacks it.

    bench = make_bench("gear_hysteresis", 3, folder)       # mechanism.toml, campaign.toml, records, truth.json
    bench = make_bench("detent", 3, folder, sizes=SIZES["hardware"], catalogue=True)
    true = true_record("gear_hysteresis", 3, {"stepping": "full", "rate": 37.0, "start_angle_deg": 45.0}, 2.0)

Both draw the same mechanism and the same size of the effect from its name and the seed; "detent+clock" is a bench of
two effects. `with_effect=False` gives the same mechanism, noise, offsets and drifts without the effect.
"""

import json
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from incomplete.effects import Size, effects_of, size_of
from incomplete.names import names_of
from incomplete.recording import RATE_HZ, Run, TrueRecord, noiseless, recorded
from incomplete.sizes import SMALL, Sizes
from mechid.campaign.campaign_file import FILE_NAME
from mechid.campaign.mechanism_text import write_mechanism
from mechid.campaign.templates import MECHANISM_NAME, RecordDraft, campaign_text
from mechid.parameter import Parameter
from mechid.plant.mechanism import Mechanism
from mechid.writing import write_atomically
from recovery.campaigns import NOISE_NM
from recovery.mechanisms import FAMILIES
from recovery.mechanisms import drawn as family_values

START_SHARE, START_DEG = 0.01, 1.0
"""How far from the truth the mechanism file starts, at most: a share of the value, of an angle."""
TOUCH, WINDOW = 1e-6, 50
"""Relative change of the stiffness, a tenth of the least error that a fit states of it, and samples of a window."""
TRUTH_NAME = "truth.json"
HEADER = "SYNTHETIC bench: its records have an effect that this file lacks; which, and the truth, is in truth.json."


@dataclass(frozen=True)
class Bench:
    """A bench on disk.

    Attributes
    ----------
    folder : Path
        With mechanism.toml, campaign.toml, one CSV a record, truth.json.
    truth : mapping of str to float
        The 15 free parameters by dotted name, in the file's units.
    size : mapping of str to float
        Of the effect, in SI units; empty where it is left away.
    runs : mapping of str to Run
        The records by name.
    """

    folder: Path
    effect: str
    seed: int
    truth: Mapping[str, float]
    size: Size
    runs: Mapping[str, Run]


def make_bench(
    effect: str,
    seed: int,
    folder: Path,
    *,
    with_effect: bool = True,
    sizes: Sizes = SMALL,
    catalogue: bool = False,
) -> Bench:
    """Write the bench of an effect and a seed into a folder; truth.json comes last, so that it tells a whole bench.

    Equal effect, seed and sizes give equal files. The mechanism is drawn from family 1 of the recovery benchmark; the
    mechanism file has the catalogue's values, or values within 1 % (angles 1 deg) of the truth. The bounds are the
    catalogue's.
    """
    mechanism, size = drawn(effect, seed, sizes=sizes)
    size = size if with_effect else {}
    folder.mkdir(parents=True, exist_ok=True)
    streams = _number(effect, sizes), seed
    runs = sizes.runs(mechanism, np.random.default_rng((*streams, 4)))
    start = FAMILIES[1].catalogue() if catalogue else _start(mechanism, np.random.default_rng((*streams, 3)))
    write_mechanism(start, folder / MECHANISM_NAME, HEADER)
    drafts = [RecordDraft(name=name, file=f"{name}.csv", command=_toml(one.command)) for name, one in runs.items()]
    named = f'mechanism = "{MECHANISM_NAME}"'
    text = campaign_text(drafts, HEADER).replace(named, f'{named}\nclock_reference = "driver"')  # a recorder is off
    write_atomically(folder / FILE_NAME, text)
    simulate = sizes.simulator(seed)
    generators = np.random.default_rng((*streams, 2)).spawn(len(runs))
    records = {}
    for (name, one), rng in zip(runs.items(), generators, strict=True):
        records[name] = recorded(mechanism, size, one, rng, simulate=simulate)
        _write_record(folder / f"{name}.csv", records[name])
    truth = {p.name: p.value for p in mechanism.free}
    told = {
        "synthetic": True,
        "effect": effect,
        "seed": seed,
        "size": dict(size),
        "parameters": truth,
        "in_library": all(sizes.effects[one].in_library for one in effects_of(effect, sizes.effects)),
    }
    if sizes.tells_more:
        told |= {
            "sizes": sizes.name,
            "simulator": simulate.__module__.rpartition(".")[2],
            "names": names_of(effect, size) if with_effect else [],
            "records": {name: dict(one.own) for name, one in records.items()},
            "effect_over_noise": _effect_over_noise(mechanism, size, runs, records),
            "predictable_s": _predictable_s(mechanism, size, runs, records),
        }
    write_atomically(folder / TRUTH_NAME, json.dumps(told, indent=1) + "\n")
    return Bench(folder, effect, seed, truth, size, runs)


def _write_record(path: Path, record: TrueRecord) -> None:
    columns = np.stack([record.time_s, record.torque_Nm], axis=1)
    np.savetxt(path, columns, fmt="%.10g", delimiter=",", header="time_s,torque_Nm", comments="")


def _effect_over_noise(
    mechanism: Mechanism, size: Size, runs: Mapping[str, Run], records: Mapping[str, TrueRecord]
) -> dict[str, float]:
    """Return by record by how much the effect changes the torque, RMS over the noise; nothing is fitted again.

    A coarse resolution is left out.
    """
    out = {}
    for name, one in runs.items():
        own = records[name].own
        nominal = {**own, "supply": 1.0, "gain": 1.0, "delay_s": 0.0}
        change = noiseless(mechanism, size, one, own) - noiseless(mechanism, {}, one, nominal)
        out[name] = round(float(np.sqrt(np.mean(change**2)) / NOISE_NM), 3)
    return out


def _predictable_s(
    mechanism: Mechanism, size: Size, runs: Mapping[str, Run], records: Mapping[str, TrueRecord]
) -> dict[str, float | None]:
    """Return by record when a stiffness that is off by `TOUCH` changes the torque by more than its noise; None: never.

    From there on a record of a gear with backlash is chaotic: no model follows it, not even the true one.
    """
    stiffness = "gear.stiffness"
    touched = mechanism.with_values({stiffness: (1.0 + TOUCH) * mechanism.value(stiffness)})
    out: dict[str, float | None] = {}
    for name, one in runs.items():
        change = noiseless(touched, size, one, records[name].own) - noiseless(mechanism, size, one, records[name].own)
        windows = change[: change.size // WINDOW * WINDOW].reshape(-1, WINDOW)
        lost = np.flatnonzero(np.sqrt(np.mean(windows**2, axis=1)) > NOISE_NM)
        out[name] = float(lost[0] * WINDOW / RATE_HZ) if lost.size else None
    return out


def true_record(
    effect: str,
    seed: int,
    command: Mapping[str, Any],
    seconds: float,
    *,
    with_effect: bool = True,
    as_recorded: bool = False,
    sample_rate_hz: float = RATE_HZ,
    sizes: Sizes = SMALL,
) -> TrueRecord:
    """Return the torque of a bench's mechanism under any command, without noise, offset and drift.

    Parameters
    ----------
    effect, seed
        As of `make_bench`.
    command : mapping
        As a campaign file writes it: ``stepping`` "full", "half" or "micro" with ``microsteps``, ``rate`` or
        ``rate_profile`` (positive, rising), ``start_angle_deg``.
    seconds : float
        Its length.
    with_effect : bool
        False leaves the effect away.
    as_recorded : bool
        True adds what is of the rig and its instruments and not of the mechanism (`Effect.in_mechanism` is False:
        filters, hum, clock, resolution, cross-axis mode); supplies, gains and triggers that differ between records
        stay nominal. False is what the mechanism itself exerts.
    sample_rate_hz : float
    sizes : Sizes
    """
    mechanism, size = drawn(effect, seed, of_rig=as_recorded, sizes=sizes)
    size = {key: value for key, value in size.items() if with_effect and key != "supply"}
    return recorded(mechanism, size, Run(command, seconds), None, sample_rate_hz)


def drawn(effect: str, seed: int, *, of_rig: bool = True, sizes: Sizes = SMALL) -> tuple[Mechanism, Size]:
    """Return the true mechanism of a bench, effect left away, and the effect's size, that of the rig or not."""
    streams = _number(effect, sizes), seed
    mechanism = FAMILIES[1].catalogue().with_values(family_values(np.random.default_rng((*streams, 0))))
    return mechanism, size_of(effect, np.random.default_rng((*streams, 1)), sizes.effects, of_rig=of_rig)


def _number(effect: str, sizes: Sizes) -> int:
    """Return the number of an effect's random streams, the same wherever it stands in the table."""
    return zlib.crc32(f"{sizes.name} {effect}".strip().encode())


def _start(mechanism: Mechanism, rng: np.random.Generator) -> Mechanism:
    """Return the mechanism with its free parameters a little off, inside their bounds."""
    return mechanism.with_values({p.name: _near(p, rng.uniform(-1.0, 1.0)) for p in mechanism.free})


def _near(p: Parameter, off: float) -> float:
    if p.is_periodic:
        return (p.value + START_DEG * off + 180.0) % 360.0 - 180.0
    return min(max(p.value * (1.0 + START_SHARE * off), p.min), p.max)


def _toml(command: Mapping[str, Any]) -> str:
    """Return a command as a campaign file writes it; JSON writes texts, numbers and lists alike."""
    return "{ " + ", ".join(f"{key} = {json.dumps(value)}" for key, value in command.items()) + " }"
