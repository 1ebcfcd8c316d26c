"""Time series and spectral densities of a budget as HDF5, with units (needs the extra ``formats``)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.budgets.budget import Budget
from mechid.budgets.mode_budget import ModeBudget
from mechid.signal.power import power_density
from mechid.writing import buffered_file, creating_folder

FILE_NAME = "disturbance.h5"


def is_available() -> bool:
    """Return whether h5py is installed."""
    try:
        import h5py
    except ImportError:
        return False
    return bool(h5py)


def write_hdf5(budget: Budget, folder: Path) -> Path:
    """Write torque and line of sight of each mode, one group per mode, every data set with its unit.

    A mode of steady rates is written at its worst rate, a profile in full.

    Raises
    ------
    UsageError
        The folder cannot be written to.
    """
    import h5py

    path = folder / FILE_NAME
    with creating_folder(folder), buffered_file(path) as content, h5py.File(content, "w") as file:
        for mode in budget.modes:
            _write_mode(file.create_group(mode.mode.name), mode, budget.file.structure.line_of_sight)
    return path


def line_of_sight_series(mode: ModeBudget) -> FloatArray:
    """Return the pointing error that the torque's lines cause at the worst rate, at the torque's times, (N, m) rad."""
    at = mode.responses[mode.worst]
    t = np.arange(at.state.torque.size) / at.state.sample_rate_hz
    total = np.zeros((t.size, at.phasors.shape[1]))
    for f, phasor in zip(at.state.frequency_hz, at.phasors, strict=True):
        total += np.real(np.exp(2j * np.pi * f * t)[:, None] * phasor)
    return total


def _write_mode(group: Any, made: ModeBudget, axes: tuple[str, ...]) -> None:
    if made.course is not None:
        torque, rate_hz = made.course.torque, made.course.sample_rate_hz
        los, los_rate_hz = made.course.series, made.course.series_rate_hz
    else:
        state = made.responses[made.worst].state
        torque, rate_hz = state.torque, state.sample_rate_hz
        los, los_rate_hz = line_of_sight_series(made), rate_hz
        group.attrs["rate_steps_per_s"] = state.rate
    frequency, density = power_density(torque, rate_hz)
    sets: dict[str, tuple[FloatArray, str]] = {
        "torque": (torque, "N*m"),
        "frequency": (frequency, "Hz"),
        "torque_psd": (density, "(N*m)^2/Hz"),
    }
    for k, axis in enumerate(axes):
        at, density = power_density(los[:, k], los_rate_hz)
        sets["line_of_sight_frequency"] = (at, "Hz")
        sets[f"line_of_sight_{axis}"] = (los[:, k], "rad")
        sets[f"line_of_sight_{axis}_psd"] = (density, "rad^2/Hz")
    group.attrs["sample_rate_Hz"] = rate_hz
    group.attrs["line_of_sight_sample_rate_Hz"] = los_rate_hz
    for name, (data, unit) in sets.items():
        group.create_dataset(name, data=data).attrs["unit"] = unit
