"""Structures of six directions at the interface, held against the equations of motion and against one another."""

import numpy as np
import pytest

from mechid.errors import InputFileError
from mechid.structure import Location, Modes, Selection, read_structure
from mechid.structure.selection import DIRECTIONS
from three_modes import DAMPING, FREQUENCY_HZ, INTERFACE, LINE_OF_SIGHT, TILT, TRANSLATION

F = np.array([0.7, 4.0, 9.0, 31.0])


def expected(shape):
    """Return the sum over the modes, (n, m)."""
    w, wk = 2.0 * np.pi * F[:, None], 2.0 * np.pi * FREQUENCY_HZ
    return (shape / (wk**2 - w**2 + 2j * DAMPING * wk * w)) @ LINE_OF_SIGHT.T


def test_a_modal_table_in_toml(toml):
    """Truth: the sum over the modes, written out."""
    structure = read_structure(toml)
    np.testing.assert_allclose(structure.along("tx", F), expected(TRANSLATION), rtol=1e-12)
    np.testing.assert_allclose(structure.along("ry", F), expected(TILT), rtol=1e-12)
    np.testing.assert_allclose(structure.along("rz", F), structure.to_line_of_sight(F), rtol=0.0)
    assert structure.along("tz", F) is None


def test_a_modal_table_in_csv(toml, tmp_path):
    """Truth: the same table in TOML; a unit in brackets is converted."""
    path = tmp_path / "modes.csv"
    columns = np.column_stack([FREQUENCY_HZ, DAMPING, INTERFACE, *LINE_OF_SIGHT, TRANSLATION * 1e3**0.5, TILT])
    header = "frequency_Hz,damping,interface,x,y,push [1/Mg^0.5],tilt"
    np.savetxt(path, columns, delimiter=",", header=header, comments="")
    named = Selection(directions={"tx": "push", "ry": "tilt"})
    structure = read_structure(path, named, axis="rz")
    assert structure.line_of_sight == ("x", "y")
    for direction in ("tx", "ry"):
        whole = read_structure(toml).along(direction, F)
        np.testing.assert_allclose(structure.along(direction, F), whole, rtol=1e-9)


@pytest.mark.data
def test_six_directions_of_a_craig_bampton_model(craig_bampton_folder):
    """Truth: NumPy's solution of (K - w^2 M + i w C) u = f for a unit force or torque along each direction.

    C is that of 1 % modal damping; the file is in mm and kg, so a force of 1 N is 1000 of its units, 1 N m a million.
    """
    from pyyeti.nastran import op4

    content = op4.read(str(craig_bampton_folder / "outboard.op4"))
    K, M = content["kxx"], content["mxx"]
    lines = {"tilt": (Location(27, "rx"),), "shift": (Location(11, "ty", 0.5),)}
    selection = Selection(interface=Location(3, "rz"), line_of_sight=lines, damping=0.01, length_unit_m=1e-3)
    structure = read_structure(craig_bampton_folder / "outboard.op4", selection)
    assert {structure.axis, *structure.directions} == set(DIRECTIONS)
    root = np.linalg.inv(np.linalg.cholesky(M))
    values, shapes = np.linalg.eigh(root @ K @ root.T)
    phi, w_k = root.T @ shapes, np.sqrt(np.where(np.arange(len(K)) < 6, 0.0, values))
    C = M @ phi @ np.diag(2.0 * 0.01 * w_k) @ phi.T @ M
    for f in (5.0, 10.9, 47.3):
        w = 2.0 * np.pi * f
        for k, direction in enumerate(DIRECTIONS):
            push = np.zeros(len(K))
            push[k] = 1e3 if k < 3 else 1e6  # grid 3 comes first, in the basic frame
            u = np.linalg.solve(K - w**2 * M + 1j * w * C, push)
            wanted = np.array([u[18 + 3], 0.5e-3 * u[6]])  # grid 11 has the output frame (y, z, x)
            found = structure.along(direction, f)[0]
            np.testing.assert_allclose(found, wanted, rtol=1e-6, atol=1e-9 * np.abs(wanted).max())


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"directions = { tx = 0.3, ry = 0.05 }": "directions = { tx = 0.3 }"}, r"mode\[1\]: directions: ry is not in"),
        ({"ry = 0.02": "ry = true"}, r"mode\[1\]: directions: ry: found True; write a finite number"),
        ({"tx": "ux"}, "directions: ux: unknown key"),
        ({"tx": "rz"}, "rz is the mechanism's own"),
        ({'axis = "rz"': ""}, "say which is the mechanism's"),
    ],
)
def test_wrong_directions_are_one_line(toml, changed, said):
    text = toml.read_text(encoding="utf-8")
    for old, new in changed.items():
        assert old in text
        text = text.replace(old, new)
    toml.write_text(text, encoding="utf-8")
    with pytest.raises(InputFileError, match=said):
        read_structure(toml)


def test_a_column_that_is_not_there(tmp_path):
    path = tmp_path / "modes.csv"
    path.write_text("frequency_Hz,damping,interface,x\n1.0,0.01,0.1,0.2\n", encoding="utf-8")
    with pytest.raises(InputFileError, match='directions: tx: no column "push"'):
        read_structure(path, Selection(directions={"tx": "push"}))
    assert isinstance(read_structure(path).model, Modes)
