"""A measuring table: a mode for each component, cross-talk, and what a laboratory knows of both.

The laboratory knows them in one of three ways: a calibration of voltages and the modes; a calibration of newtons and a
hammer test of each axis in a CSV file; a hammer test of all 36 pairs in a MAT file, which holds the cross-talk too.
"""

from dataclasses import dataclass

import numpy as np
from scipy.io import savemat

CROSS_TALK = 0.03
MODES_HZ = (900.0, 1400.0)
DIRECTIONS = ("fx", "fy", "fz", "mx", "my", "mz")
CALIBRATED, FREQUENCY, DAMPING, HAMMER = 0.003, 0.005, 0.2, 0.01
"""Relative standard errors of what the laboratory knows."""
PAIR = '["N", "N*m"]'


@dataclass
class Table:
    frequency_hz: np.ndarray
    damping: np.ndarray
    cross_talk: np.ndarray
    scale: np.ndarray
    """Sizes of the components, which the cross-talk is relative to."""

    def response(self, frequency):
        """Return what the modes make of a load, (6, n)."""
        r = np.asarray(frequency) / self.frequency_hz[:, None]
        return 1.0 / (1.0 - r**2 + 2j * self.damping[:, None] * r)

    def periodic(self, load, sample_rate_hz):
        """Return what the modes make of loads that repeat with the record, (6, N)."""
        frequency = np.fft.rfftfreq(load.shape[1], 1.0 / sample_rate_hz)
        return np.fft.irfft(np.fft.rfft(load) * self.response(frequency), load.shape[1])


def make_table(rng, scale):
    """Return a table with its modes and cross-talk drawn."""
    away = CROSS_TALK * rng.choice([-1.0, 1.0], (6, 6)) * scale[:, None] / scale[None, :]
    np.fill_diagonal(away, 0.0)
    return Table(rng.uniform(*MODES_HZ, 6), rng.uniform(0.005, 0.03, 6), np.eye(6) + away, scale)


def know_table(table, rng, way, folder, exact=False):
    """Return what a laboratory declares of a table, as options of `write_bench`; files go into the folder."""
    size = 0.0 if exact else 1.0
    off = size * CALIBRATED * rng.normal(size=(6, 6)) * table.scale[:, None] / table.scale[None, :]
    matrix = np.linalg.inv(table.cross_talk) + off
    folder.mkdir(parents=True, exist_ok=True)
    percent = f"uncertainty_percent = {100.0 * CALIBRATED}"
    if way == 0:
        newtons = np.array([20.0, 20.0, 40.0, 2.0, 2.0, 1.0])  # a volt, as a charge amplifier is set
        modes = ", ".join(
            f'{{ direction = "{d}", frequency_hz = {float(f * (1.0 + size * FREQUENCY * rng.normal()))}, '
            f"damping = {float(z * np.exp(size * DAMPING * rng.normal()))} }}"
            for d, f, z in zip(DIRECTIONS, table.frequency_hz.tolist(), table.damping.tolist(), strict=True)
        )
        declared = (
            f'calibration = {{ {_matrix(matrix * newtons)}, input_unit = "V", output_unit = {PAIR}, {percent} }}\n'
        )
        declared += f"table_response = {{ modes = [{modes}], uncertainty_percent = {100.0 * FREQUENCY} }}\n"
        return {"declared": declared, "unit": "V", "to_channels": np.diag(1.0 / newtons)}
    frequency = np.arange(4.0, 1500.0, 2.0)
    response = table.response(frequency)
    # of the magnitude, as the declared error is; the phase has as much
    parts = rng.normal(size=(2, 6, 6, frequency.size))
    noise = size * HAMMER * (parts[0] + 1j * parts[1])
    if way == 1:
        seen = response * (1.0 + noise[0])
        header = "frequency_Hz," + ",".join(f"{d}_re [1],{d}_im [1]" for d in DIRECTIONS)
        columns = [frequency, *(part for row in seen for part in (row.real, row.imag))]
        np.savetxt(folder / "table.csv", np.column_stack(columns), delimiter=",", header=header, comments="")
        declared = f"calibration = {{ {_matrix(matrix)}, input_unit = {PAIR}, output_unit = {PAIR}, {percent} }}\n"
        return {
            "declared": declared + f'table_response = {{ file = "table.csv", uncertainty_percent = {100 * HAMMER} }}\n'
        }
    whole = table.cross_talk[:, :, None] * response[None, :, :] * (1.0 + noise)
    savemat(folder / "table.mat", {"frequency_hz": frequency, "response": np.moveaxis(whole, -1, 0)})
    return {
        "declared": f'table_response = {{ file = "table.mat", uncertainty_percent = {100 * HAMMER}, '
        f"input_unit = {PAIR}, output_unit = {PAIR} }}\n"
    }


def _matrix(matrix):
    return "matrix = [" + ", ".join(str(row) for row in matrix.tolist()) + "]"
