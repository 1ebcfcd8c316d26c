"""One structure in every format. Truth: the transfer functions of the sum over its modes."""

import sys

import numpy as np
import pytest
from scipy import signal
from scipy.io import savemat

from mechid.errors import InputFileError, UsageError
from mechid.structure import Location, Selection, from_state_space, read_structure
from mechid.structure.uff import read_uff
from three_modes import DAMPING, FREQUENCY_HZ, INTERFACE, LINE_OF_SIGHT, NAMES, receptance

GRID_HZ = np.arange(1.0, 100.0, 0.05)
"""Fine enough for the resonances; the responses are compared at its own points."""


def modal_toml(folder):
    rows = zip(FREQUENCY_HZ, DAMPING, INTERFACE, LINE_OF_SIGHT.T, strict=True)
    text = 'axis = "rz"\nline_of_sight = ["los_x", "los_y"]\n'
    for f, zeta, phi, psi in rows:
        text += f"[[mode]]\nfrequency_hz = {f}\ndamping = {zeta}\ninterface = {phi}\nline_of_sight = {psi.tolist()}\n"
    return written(folder / "modes.toml", text)


def modal_csv(folder):
    text = "frequency_Hz,damping,interface,los_x [urad/(kg^0.5*m)],los_y\n"
    for f, zeta, phi, (x, y) in zip(FREQUENCY_HZ, DAMPING, INTERFACE, LINE_OF_SIGHT.T, strict=True):
        text += f"{f},{zeta},{phi},{x * 1e6},{y}\n"
    return written(folder / "modes.csv", text)


def response_csv(folder):
    """Interface as accelerance by magnitude and phase, los_x in urad, los_y in SI without a unit."""
    h = receptance(GRID_HZ)
    a = -((2.0 * np.pi * GRID_HZ) ** 2) * h[:, 0]
    columns = [GRID_HZ, np.abs(a), np.degrees(np.angle(a)), 1e6 * h[:, 1].real, 1e6 * h[:, 1].imag]
    columns += [h[:, 2].real, h[:, 2].imag]
    head = "frequency_Hz;interface_mag [rad/s^2/(N*m)];interface_phase_deg;los_x_re [urad/(N m)];los_x_im [urad/(N m)]"
    lines = [";".join(f"{value:.17g}" for value in row) for row in np.array(columns).T]
    return written(folder / "frf.csv", "# made up\n" + "\n".join([head + ";los_y_re;los_y_im", *lines]) + "\n")


def response_mat(folder):
    h = receptance(GRID_HZ)
    content = {"frequency_hz": GRID_HZ, "interface": h[:, 0], "line_of_sight": h[:, 1:], "unit": "rad/(N*m)"}
    savemat(folder / "frf.mat", content | {"line_of_sight_names": np.array(NAMES, dtype=object)})
    return folder / "frf.mat"


def modal_mat(folder):
    content = {"frequency_hz": FREQUENCY_HZ, "damping": DAMPING, "interface": INTERFACE, "line_of_sight": LINE_OF_SIGHT}
    savemat(folder / "modes.mat", content | {"line_of_sight_names": np.array(NAMES, dtype=object)})
    return folder / "modes.mat"


def system_mat(folder, modes):
    A, B, C = modes.state_space()
    savemat(folder / "system.mat", {"A": A, "B": B, "C": C, "line_of_sight_names": np.array(NAMES, dtype=object)})
    return folder / "system.mat"


def uff(folder):
    """Mobilities in urad/s, the interface's by its reverse direction."""
    pyuff = pytest.importorskip("pyuff")
    h = receptance(GRID_HZ) * (2j * np.pi * GRID_HZ)[:, None] * 1e6
    sets = [(3, -6, -h[:, 0]), (1, 4, h[:, 1]), (1, 5, h[:, 2])]
    file = pyuff.UFF(str(folder / "frf.uff"))
    for node, direction, data in sets:
        file.write_sets(
            pyuff.prepare_58(
                binary=0,
                func_type=4,
                rsp_node=node,
                rsp_dir=direction,
                ref_node=3,
                ref_dir=6,
                data=data,
                x=GRID_HZ,
                id1="made up",
                rsp_ent_name="structure",
                ref_ent_name="structure",
                abscissa_spacing=1,
                abscissa_spec_data_type=18,
                ordinate_spec_data_type=11,
                orddenom_spec_data_type=13,
                ordinate_axis_units_lab="urad/s",
                orddenom_axis_units_lab="N*m",
            ),
            "add" if (folder / "frf.uff").exists() else "overwrite",
        )
    return folder / "frf.uff"


UFF_SELECTION = Selection(
    interface=Location(3, "rz"), line_of_sight={"los_x": (Location(1, "rx"),), "los_y": (Location(1, "ry"),)}
)


def written(path, text):
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("make", [modal_toml, modal_csv, response_csv, response_mat, modal_mat, uff])
def test_every_format_holds_the_same_structure(make, tmp_path):
    """Truth: the sum over modes, written out."""
    structure = read_structure(make(tmp_path), UFF_SELECTION if make is uff else None)
    assert structure.line_of_sight == NAMES
    f = GRID_HZ[1:-1]  # its ends are rounded in a text file
    expected = receptance(f)
    scale = np.abs(expected)
    tolerance = 1e-5 if make is uff else 1e-9  # ASCII data sets have six digits
    assert (np.abs(structure.to_interface(f) - expected[:, 0]) / scale[:, 0]).max() < tolerance
    assert (np.abs(structure.to_line_of_sight(f) - expected[:, 1:]) / scale[:, 1:]).max() < tolerance
    assert not [line for line in structure.warnings if "1/f^2" not in line]


@pytest.mark.parametrize("make", ["scipy", "control", "mat"])
def test_a_state_space_is_the_same_structure(make, modes, tmp_path):
    """Truth: the sum over modes, written out."""
    A, B, C = modes.state_space()
    if make == "mat":
        structure = read_structure(system_mat(tmp_path, modes))
    elif make == "scipy":
        structure = from_state_space(signal.StateSpace(A, B, C, np.zeros((3, 1))), NAMES)
    else:
        control = pytest.importorskip("control")
        structure = from_state_space(control.ss(A, B, C, np.zeros((3, 1))), NAMES)
    f = np.array([0.5, 17.9, 18.0, 40.0, 61.0])
    expected = receptance(f)
    np.testing.assert_allclose(structure.to_interface(f), expected[:, 0], rtol=1e-9)
    np.testing.assert_allclose(structure.to_line_of_sight(f), expected[:, 1:], rtol=1e-9)
    assert structure.warnings == ()


def test_outside_its_coverage_a_response_is_not_known(tmp_path):
    structure = read_structure(response_csv(tmp_path))
    assert structure.coverage_hz == (1.0, GRID_HZ[-1])
    assert np.isnan(structure.to_line_of_sight([0.5, 200.0])).all()
    assert np.isfinite(structure.to_line_of_sight([50.0])).all()


REFUSED = {
    "frf.csv": [
        ("frequency_Hz,los_x_re\n1,2\n", 'frf.csv: no column "los_x_im"'),
        ("frequency_Hz,los_x_re [m/N],los_x_im\n1,2,3\n2,2,3\n", 'unit "m/N" does not fit a response to a torque'),
        ("frequency_Hz,los_x_re,los_x_im\n2,2,3\n1,2,3\n", "1 Hz comes after 2 Hz"),
        ("frequency_Hz,los_x_re,los_x_im\n1,2,x\n", 'line 2: column "los_x_im": found "x"'),
        ("frequncy_Hz,los_x_re,los_x_im\n1,2,3\n", 'no column "frequency_Hz"; did you mean "frequncy_Hz"'),
        ("frequency_Hz,damping,interface\n1,0.1,1\n", "no line of sight"),
        ("frequency_Hz,interface,los_x\n1,0.1,1\n", "contains no damping"),
        ("frequency_Hz,damping,interface,los_x\n1,-0.1,1,1\n", "damping of mode 0: found -0.1"),
    ],
    "modes.toml": [
        ('line_of_sight = ["x"]\nmodes = 3\n', 'modes: unknown key; did you mean "mode"'),
        ('line_of_sight = ["x"]\n[[mode]]\nfrequency = 3\n', 'frequency: unknown key; did you mean "frequency_hz"'),
        (
            'line_of_sight = ["x"]\n[[mode]]\nfrequency_hz = "3 Hz"\ndamping = 0\ninterface = 1\nline_of_sight = [1]\n',
            "frequency_hz: found 3 Hz; write a finite number",
        ),
        ('line_of_sight = ["x"]\n[[mode]]\nline_of_sight = [1, 2]\n', "write 1 numbers, one for each axis"),
        ("[[mode]]\n", "line_of_sight: name the axes"),
        ('line_of_sight = ["x"]\naxis = "z"\n', 'axis: found "z"; write "rx"'),
    ],
}


@pytest.mark.parametrize(("name", "text", "said"), [(n, t, s) for n, cases in REFUSED.items() for t, s in cases])
def test_what_is_wrong_is_said_with_its_place(name, text, said, tmp_path):
    with pytest.raises(InputFileError) as caught:
        read_structure(written(tmp_path / name, text))
    assert said in str(caught.value)
    assert str(caught.value).startswith(name)


def test_a_system_that_cannot_be_is_refused(modes):
    A, B, C = modes.state_space()
    with pytest.raises(UsageError, match="2 outputs"):
        from_state_space(signal.StateSpace(A, B, C, np.zeros((3, 1))), ("x",))
    with pytest.raises(UsageError, match="is discrete with dt"):
        from_state_space(signal.StateSpace(A, B, C, np.zeros((3, 1)), dt=0.1), NAMES)
    with pytest.raises(InputFileError, match="has an unstable pole"):
        from_state_space(signal.StateSpace(A + 3.0 * np.eye(6), B, C, np.zeros((3, 1))), NAMES)


def test_a_missing_library_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyuff", None)
    path = written(tmp_path / "a.uff", "-1\n")
    with pytest.raises(InputFileError, match="needs pyuff; pip install"):
        read_uff(path, UFF_SELECTION)  # in this process, which lacks it


@pytest.mark.parametrize("mode", ["1.5", '"text"', "[]", "true"])
def test_a_mode_that_is_no_table_is_refused(tmp_path, mode):
    path = written(tmp_path / "modes.toml", f'line_of_sight = ["x"]\nmode = [{mode}]\n')
    with pytest.raises(InputFileError, match=r"modes\.toml: mode\[0\]: found .*; write each mode as a table under"):
        read_structure(path)


@pytest.mark.parametrize("key", ["interface", "frequency_hz", "damping_percent", "line_of_sight"])
@pytest.mark.parametrize("value", ["1e308", "1.7e308"])
def test_numbers_whose_response_is_none_are_refused(tmp_path, key, value):
    """Truth: the largest double is 1.8e308; products of these are none."""
    numbers = {"frequency_hz": "20.0", "damping_percent": "1.0", "interface": "0.1", "line_of_sight": "[0.2]"}
    numbers[key] = f"[{value}]" if key == "line_of_sight" else value
    lines = "\n".join(f"{name} = {number}" for name, number in numbers.items())
    with pytest.raises(
        InputFileError, match=r"modes\.toml: .*its response at .* Hz is not finite or is too large for a structure"
    ):
        read_structure(written(tmp_path / "modes.toml", f'line_of_sight = ["x"]\n[[mode]]\n{lines}\n'))


@pytest.mark.parametrize("value", ["1e308", "-1.7e308"])
def test_a_response_that_no_structure_has_is_refused(tmp_path, value):
    rows = "\n".join(f"{f},1e-6,0,{value},0" for f in range(1, 20))
    path = written(tmp_path / "frf.csv", f"frequency_Hz,interface_re,interface_im,los_x_re,los_x_im\n{rows}\n")
    with pytest.raises(InputFileError, match=r"is not finite or is too large for a structure"):
        read_structure(path)
