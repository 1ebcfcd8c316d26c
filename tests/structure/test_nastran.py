"""Nastran models, held against published frequencies and against mechanics."""

import subprocess
import sys

import numpy as np
import pytest

from mechid.errors import InputFileError
from mechid.structure import Location, Selection, read_structure

pytestmark = pytest.mark.data

PUBLISHED_HZ = [1.6965, 1.7661, 1.8551, 3.3886, 6.880, 6.881, 10.610]
OUTBOARD_HZ = [10.789, 10.791, 13.940]
"""Of the coupled system, and of its outboard superelement clamped at its boundary (printed by Nastran)."""


def selected(**changed):
    entries = {
        "interface": Location(3, "rz"),
        "line_of_sight": {"x": (Location(27, "rx"),), "y": (Location(11, "ry"), Location(19, "tz", 1e-3))},
        "damping": 0.005,
        "length_unit_m": 1e-3,
    }
    return Selection(**(entries | changed))


def test_the_published_frequencies_of_the_coupled_system(craig_bampton_folder, figure):
    """Truth: the frequencies published with the model."""
    structure = read_structure(craig_bampton_folder / "nas2cam.op2", selected(), axis="rz")
    f = structure.model.frequency_hz
    np.testing.assert_array_equal(f[:6], 0.0)
    for found, published in zip(f[6:13], PUBLISHED_HZ, strict=True):
        figure("Craig-Bampton: a frequency", found, least=published - 6e-4, most=published + 6e-4, unit="Hz")


def test_a_craig_bampton_model_solved_here(craig_bampton_folder):
    """Truth: Nastran's frequencies of the superelement with its boundary held, which its own file prints."""
    from pyyeti.nastran import op4

    from mechid.structure.nastran import solve_modes

    content = op4.read(str(craig_bampton_folder / "outboard.op4"))
    inner = slice(24, None)  # four boundary grids come first
    values, _ = solve_modes(content["kxx"][inner, inner], content["mxx"][inner, inner], "outboard.op4")
    f = np.sqrt(values) / (2.0 * np.pi)
    for printed in OUTBOARD_HZ:
        assert np.abs(f - printed).min() < 6e-4


def test_a_craig_bampton_model_has_the_inertia_of_its_rigid_body(craig_bampton_folder):
    """Truth: Newton. Far below its modes, J of 1/(J w^2) is the one that the mass matrix has about the interface."""
    from pyyeti.nastran import bulk, n2p, op4

    content = op4.read(str(craig_bampton_folder / "outboard.op4"))
    uset = bulk.asm2uset(str(craig_bampton_folder / "outboard.asm"))[0]
    rigid = n2p.rbgeom_uset(uset, 3)
    inverse = np.linalg.inv(rigid.T @ content["mxx"] @ rigid)  # of the free body, about grid 3
    structure = read_structure(
        craig_bampton_folder / "outboard.op4", selected(line_of_sight={"z": (Location(3, "rz"),)})
    )
    assert structure.model.rigid.sum() == 6
    w = 2.0 * np.pi * 1e-3
    expected = -inverse[5, 5] / w**2 * 1e6  # mm^2 to m^2, and the mass unit is kg
    np.testing.assert_allclose(structure.to_interface(1e-3)[0].real, expected, rtol=1e-5)


def test_a_grid_in_a_frame_of_its_own_is_turned_to_the_basic_one(craig_bampton_folder):
    """Truth: a rigid body turns the same everywhere; grid 11 has the output frame (y, z, x)."""
    lines = {"there": (Location(3, "rx"),), "here": (Location(11, "rx"),)}
    structure = read_structure(craig_bampton_folder / "outboard.op4", selected(line_of_sight=lines))
    there, here = structure.model.line_of_sight[:, structure.model.rigid]
    np.testing.assert_allclose(there, here, atol=1e-6 * np.abs(there).max())


def test_modes_left_out_leave_their_flexibility(craig_bampton_folder):
    """Truth: the whole model. At a tenth of the limit the truncated one is within 2 %."""
    whole = read_structure(craig_bampton_folder / "nas2cam.op2", selected())
    part = read_structure(craig_bampton_folder / "nas2cam.op2", selected(highest_hz=30.0))
    assert part.model.frequency_hz.size < whole.model.frequency_hz.size
    f = np.array([3.0])
    np.testing.assert_allclose(part.to_interface(f), whole.to_interface(f), rtol=0.02)


@pytest.mark.parametrize(
    ("name", "changed", "said"),
    [
        ("nas2cam.op2", {"interface": None}, "nas2cam.op2: its nodes are numbered; give interface"),
        ("nas2cam.op2", {"interface": Location(3, "tz")}, 'interface direction "tz"'),
        ("nas2cam.op2", {"interface": Location(99, "rz")}, "no grid 99; it holds 3, 4, 5"),
        ("outboard.op4", {"damping": None}, "contains no damping"),
        ("outboard.op4", {"line_of_sight": {}}, "give line_of_sight"),
        ("residual.op2", {}, "needs residual.op4 in the same folder"),
    ],
)
def test_what_is_missing_is_said(craig_bampton_folder, name, changed, said):
    with pytest.raises(InputFileError, match=said):
        read_structure(craig_bampton_folder / name, selected(**changed))


def test_another_axis_than_the_mechanisms_is_refused(craig_bampton_folder):
    with pytest.raises(InputFileError, match="torque about rz but the mechanism turns about rx"):
        read_structure(craig_bampton_folder / "nas2cam.op2", selected(), axis="rx")


def test_reading_leaves_numpys_printing_alone(craig_bampton_folder):
    """Truth: NumPy's options before. pyYeti changes them when it is imported."""
    code = (
        "import numpy as np; from mechid.structure import *; before = np.get_printoptions();"
        f"read_structure({str(craig_bampton_folder / 'outboard.op4')!r}, Selection(interface=Location(3, 'rz'),"
        "line_of_sight={'x': (Location(3, 'rx'),)}, damping=0.01)); assert np.get_printoptions() == before"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
