"""Frequency responses in CSV. Truth: the modes that they were sampled from."""

import numpy as np
import pytest

import mechid
from mechid.structure import Selection, read_structure
from three_modes import receptance


def test_responses_in_csv(toml, tmp_path):
    """Truth: the modes that the responses were sampled from; of a force as mobility in mrad/s/N."""
    modal, grid = read_structure(toml), np.linspace(0.5, 40.0, 200)
    torque, force = modal.to_line_of_sight(grid), modal.along("tx", grid) * (2j * np.pi * grid)[:, None] * 1e3
    columns, header = [grid], ["frequency_Hz"]
    for k, name in enumerate(("x", "y")):
        columns += [torque[:, k].real, torque[:, k].imag, force[:, k].real, force[:, k].imag]
        header += [f"{name}_re", f"{name}_im", f"{name}_push_re [mrad/s/N]", f"{name}_push_im [mrad/s/N]"]
    path = tmp_path / "responses.csv"
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=",".join(header), comments="", fmt="%.12e")
    structure = read_structure(path, Selection(directions={"tx": "push"}), axis="rz")
    at = grid[::20]
    np.testing.assert_allclose(structure.along("tx", at), modal.along("tx", at), rtol=1e-9)
    np.testing.assert_allclose(structure.to_line_of_sight(at), modal.to_line_of_sight(at), rtol=1e-9)


GRID_HZ = np.arange(1.0, 100.0, 0.05)
H = receptance(GRID_HZ)[:, 1]


def response_csv(folder, columns):
    table = {"frequency_Hz": GRID_HZ, **columns}
    rows = "\n".join(",".join(f"{value:.17g}" for value in row) for row in zip(*table.values(), strict=True))
    (folder / "frf.csv").write_text(f"{','.join(table)}\n{rows}\n", encoding="utf-8")
    return folder / "frf.csv"


@pytest.mark.parametrize(("name", "factor"), [("frequency [rad/s]", 2.0 * np.pi), ("frequency [kHz]", 1e-3)])
def test_the_frequencies_of_a_response_have_the_unit_of_their_header(tmp_path, name, factor):
    path = response_csv(tmp_path, {"x_re": H.real, "x_im": H.imag})
    _, *rows = path.read_text().splitlines()
    scaled = [f"{float(row.split(',')[0]) * factor:.17g},{','.join(row.split(',')[1:])}" for row in rows]
    path.write_text("\n".join([f"{name},x_re,x_im", *scaled]) + "\n", encoding="utf-8")
    assert mechid.load_structure(path).coverage_hz == pytest.approx((GRID_HZ[0], GRID_HZ[-1]), rel=1e-12)
