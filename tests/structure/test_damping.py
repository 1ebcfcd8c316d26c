"""Damping in percent. Truth: the ratio that was written as percent; what only looks like it is asked about."""

import numpy as np
import pytest
from scipy.io import savemat

import mechid
from mechid.budgets.flight_entry import read_flight
from mechid.budgets.structure_entry import read_structure_entry
from mechid.campaign.place import Place
from mechid.errors import InputFileError
from mechid.structure import Selection, read_structure

SHAPES = [0.15, -0.04]


def modal_csv(folder, header, *dampings, columns=""):
    lines = "".join(f"{20.0 + k},{zeta},0.15,-0.04{columns}\n" for k, zeta in enumerate(dampings))
    (folder / "modes.csv").write_text(f"frequency_Hz,{header}\n{lines}", encoding="utf-8")
    return folder / "modes.csv"


def modal_toml(folder, damping):
    text = (
        f'line_of_sight = ["x"]\n[[mode]]\nfrequency_hz = 20.0\n{damping}\ninterface = 0.15\nline_of_sight = [-0.04]\n'
    )
    (folder / "modes.toml").write_text(text, encoding="utf-8")
    return folder / "modes.toml"


def modal_mat(folder, **damping):
    shapes = {"frequency_hz": [20.0, 30.0], "interface": [0.1, 0.2], "line_of_sight": [[0.3, 0.4]]}
    savemat(folder / "modes.mat", {**shapes, **damping})
    return folder / "modes.mat"


def structure_entry(folder, **entry):
    return read_structure_entry({"structure": entry}, Place("budget.toml"), folder)[0]


@pytest.mark.parametrize(
    "name",
    ["damping [%]", "damping (%)", "damping[percent]", "damping_percent", "zeta [%]", "Damping ratio [%]", "xi (%)"],
)
def test_a_column_in_percent_is_read_in_percent(tmp_path, name):
    """Truth: 0.5 % and 2 % of critical damping are ratios of 0.005 and 0.02."""
    model = mechid.load_structure(modal_csv(tmp_path, f"{name},interface,x", 0.5, 2.0)).model
    assert model.damping == pytest.approx([0.005, 0.02], rel=1e-15)
    assert model.line_of_sight.shape == (1, 2)


@pytest.mark.parametrize("name", ["damping", "zeta", "Damping_Ratio", "damping ratio", "modal damping"])
def test_a_large_damping_without_a_unit_is_asked_about(tmp_path, name):
    """Truth: 0.5 and 2 are percent as tables of modes have them; as shares of critical they damp out every mode."""
    with pytest.raises(InputFileError, match=r'found 2, which is read as 200 % .*"damping \[%\]" if percent is meant'):
        mechid.load_structure(modal_csv(tmp_path, f"{name},interface,x", 0.5, 2.0))
    model = mechid.load_structure(modal_csv(tmp_path, f"{name},interface,x", 0.005, 0.2)).model
    assert model.damping.tolist() == [0.005, 0.2]


@pytest.mark.parametrize("unit", ["1", "-", "ratio"])
def test_a_large_damping_with_its_unit_is_believed(tmp_path, unit):
    model = mechid.load_structure(modal_csv(tmp_path, f"damping [{unit}],interface,x", 0.3, 1.2)).model
    assert model.damping.tolist() == [0.3, 1.2]


@pytest.mark.parametrize(
    ("name", "remedy"),
    [
        ("Q", r"quality factor; write a column \"damping\" with 1/\(2 Q\)"),
        ("quality_factor", r"1/\(2 Q\)"),
        ("eta", "half of it"),
        ("loss factor", "half of it"),
        ("structural damping [%]", "half of it"),
    ],
)
def test_another_measure_of_damping_is_named(tmp_path, name, remedy):
    with pytest.raises(InputFileError, match=remedy):
        read_structure(modal_csv(tmp_path, f"{name},interface,x", 0.01, 0.01), Selection(damping=0.01))


@pytest.mark.parametrize(
    "name", ["mode", "No", "mode_no", "modal mass", "generalized_mass", "omega", "omega_rad_s", "effective mass"]
)
def test_a_column_that_is_no_shape_is_no_line_of_sight(tmp_path, name):
    with pytest.raises(InputFileError, match="leave it out"):
        mechid.load_structure(modal_csv(tmp_path, f"damping,interface,x,{name}", 0.01, 0.01, columns=",1"))


def test_damping_stands_once(tmp_path):
    with pytest.raises(InputFileError, match=r"zeta.*holds damping, as does another column; remove one"):
        mechid.load_structure(modal_csv(tmp_path, "damping,interface,x,zeta", 0.01, 0.01, columns=",0.02"))
    with pytest.raises(InputFileError, match="has both damping and damping_percent; remove one"):
        mechid.load_structure(modal_toml(tmp_path, "damping = 0.01\ndamping_percent = 1.0"))


def test_a_unit_of_something_else_is_refused(tmp_path):
    with pytest.raises(InputFileError, match=r'column "damping": unit "N m s" is not valid here; expected 1 or %'):
        mechid.load_structure(modal_csv(tmp_path, "damping [N m s],interface,x", 0.01))


@pytest.mark.parametrize(("column", "values"), [("frequency [rad/s]", 2.0 * np.pi), ("frequency [kHz]", 1e-3)])
def test_frequencies_are_read_in_the_unit_that_the_header_states(tmp_path, column, values):
    (tmp_path / "modes.csv").write_text(f"{column},damping,interface,x\n{20.0 * values:.17g},0.01,0.15,-0.04\n")
    assert mechid.load_structure(tmp_path / "modes.csv").model.frequency_hz == pytest.approx([20.0], rel=1e-12)


@pytest.mark.parametrize(
    ("column", "message"),
    [
        ("frequency", r'states no unit; write "frequency_Hz", or "frequency \[rad/s\]"'),
        ("frequency_Hz [rad/s]", r'has unit "rad/s"; write "frequency \[rad/s\]" if the unit is right'),
        ("frequency [N m]", 'unit "N m" is not valid here; expected Hz or rad/s'),
    ],
)
def test_a_frequency_without_a_clear_unit_is_asked_about(tmp_path, column, message):
    (tmp_path / "modes.csv").write_text(f"{column},damping,interface,x\n20,0.01,0.15,-0.04\n")
    with pytest.raises(InputFileError, match=message):
        mechid.load_structure(tmp_path / "modes.csv")


def test_percent_in_every_other_file_and_table(tmp_path):
    """Truth: one mode of 0.5 %, however it is written."""
    toml = mechid.load_structure(modal_toml(tmp_path, "damping_percent = 0.5"))
    mat = mechid.load_structure(modal_mat(tmp_path, damping_percent=0.5))
    rows = modal_csv(tmp_path, "interface,x")
    rows.write_text("frequency_Hz,interface,x\n20,0.15,-0.04\n", encoding="utf-8")
    given = structure_entry(tmp_path, file="modes.csv", damping_percent=0.5)
    for structure in (toml, mat, given):
        assert structure.model.damping == pytest.approx(0.005, rel=1e-15)
    flight = {"load_mode": [{"frequency_hz": 3.0, "damping_percent": 0.5, "inertia": 1.0}]}
    assert read_flight(flight, Place("budget.toml").key("flight")).load_modes[0].damping == pytest.approx(0.005)


def test_percent_is_asked_about_in_every_other_file_and_table(tmp_path):
    remedy = "write damping_percent = 0.5 if percent is meant, damping_percent = 50 if the share of critical is"
    with pytest.raises(InputFileError, match=rf"modes.toml: mode\[0\]: damping: .*{remedy}"):
        mechid.load_structure(modal_toml(tmp_path, "damping = 0.5"))
    with pytest.raises(InputFileError, match=rf"modes.mat: damping: .*{remedy}"):
        mechid.load_structure(modal_mat(tmp_path, damping=[0.5, 0.01]))
    with pytest.raises(InputFileError, match=rf"budget.toml: structure.damping: .*{remedy}"):
        structure_entry(tmp_path, file="modes.csv", damping=0.5)
    flight = {"load_mode": [{"frequency_hz": 3.0, "damping": 0.5, "inertia": 1.0}]}
    with pytest.raises(InputFileError, match=rf"budget.toml: flight.load_mode\[0\].damping: .*{remedy}"):
        read_flight(flight, Place("budget.toml").key("flight"))


def test_a_controller_may_be_damped_well_and_is_asked_about_in_percent(tmp_path):
    path = modal_toml(tmp_path, "damping = 0.01")
    path.write_text(path.read_text().replace("frequency_hz = 20.0", "frequency_hz = 0.0"), encoding="utf-8")
    control = {"bandwidth_hz": 0.05, "damping": 0.7}
    assert structure_entry(tmp_path, file="modes.toml", attitude_control=control).model.damping.tolist() == [0.7]
    in_percent = {"bandwidth_hz": 0.05, "damping_percent": 70.0}
    assert structure_entry(tmp_path, file="modes.toml", attitude_control=in_percent).model.damping == pytest.approx(0.7)
    with pytest.raises(InputFileError, match=r"attitude_control.damping: found 70.*write damping_percent = 70"):
        structure_entry(tmp_path, file="modes.toml", attitude_control=control | {"damping": 70.0})
