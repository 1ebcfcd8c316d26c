"""Time series and densities of a budget as HDF5, with units (needs the extra ``formats``)."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechid.budget.budget import Budget, ModeBudget
from mechid.errors import UsageError
from mechid.signal.power import power_density

FloatArray = NDArray[np.float64]

FILE_NAME = "disturbance.h5"


def is_available() -> bool:
    """Whether h5py is there."""
    try:
        import h5py
    except ImportError:
        return False
    return bool(h5py)


def write_hdf5(budget: Budget, folder: Path) -> Path:
    """Write torque and line of sight of each mode at its worst rate: a group a mode, every data set with its unit.

    Raises
    ------
    UsageError
        The folder cannot be written to.
    """
    import h5py

    path = folder / FILE_NAME
    beside = folder / f".{FILE_NAME}.{os.getpid()}.part"
    try:
        with h5py.File(beside, "w") as file:
            for mode in budget.modes:
                _write_mode(file.create_group(mode.mode.name), mode, budget.file.structure.line_of_sight)
        beside.replace(path)
    except OSError as error:
        raise UsageError(f"{folder}: cannot be written to ({error}); give another folder") from error
    finally:
        beside.unlink(missing_ok=True)
    return path


def line_of_sight_series(mode: ModeBudget) -> FloatArray:
    """Return the line of sight that the lines make at the worst rate, over the torque's samples, (N, m) rad."""
    at = mode.responses[mode.worst]
    t = np.arange(at.state.torque.size) / at.state.sample_rate_hz
    total = np.zeros((t.size, at.phasors.shape[1]))
    for f, phasor in zip(at.state.frequency_hz, at.phasors, strict=True):
        total += np.real(np.exp(2j * np.pi * f * t)[:, None] * phasor)
    return total


def _write_mode(group: Any, mode: ModeBudget, axes: tuple[str, ...]) -> None:
    state = mode.responses[mode.worst].state
    los = line_of_sight_series(mode)
    frequency, torque = power_density(state.torque, state.sample_rate_hz)
    sets: dict[str, tuple[FloatArray, str]] = {
        "torque": (state.torque, "N*m"),
        "frequency": (frequency, "Hz"),
        "torque_psd": (torque, "(N*m)^2/Hz"),
    }
    for k, axis in enumerate(axes):
        sets[f"line_of_sight_{axis}"] = (los[:, k], "rad")
        sets[f"line_of_sight_{axis}_psd"] = (power_density(los[:, k], state.sample_rate_hz)[1], "rad^2/Hz")
    group.attrs["rate_steps_per_s"] = state.rate
    group.attrs["sample_rate_Hz"] = state.sample_rate_hz
    for name, (data, unit) in sets.items():
        group.create_dataset(name, data=data).attrs["unit"] = unit
