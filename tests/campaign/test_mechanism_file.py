"""The mechanism file: what it may say, and a message for each way it can be wrong."""

import re

import numpy as np
import pytest

from mechid.campaign import mechanism_from_table, read_mechanism
from mechid.campaign.mechanism_file import mechanism_warnings
from mechid.campaign.mechanism_structure import divisors
from mechid.errors import InputFileError
from mechid.parameter import Status
from mechid.plant.detent import detent_order


@pytest.fixture
def mechanism(folder):
    return read_mechanism(folder / "mechanism.toml")


def test_every_declared_parameter_is_there_in_the_order_of_the_plant(mechanism):
    assert list(mechanism.parameters) == list(mechanism.plant.declarations)
    assert mechanism.options == {"assembly": "stepper_gear_mass", "housing.form": "paper"}


def test_a_bare_number_is_known(mechanism):
    ratio = mechanism.parameters["gear.ratio"]
    assert (ratio.value, ratio.status, ratio.sigma) == (-50.0, Status.KNOWN, None)


def test_a_table_is_free_from_its_value_also_on_a_bound(mechanism):
    names = ["stepper.coil_resistance", "stepper.detent.0.amplitude", "stepper.detent.0.phase_deg"]
    names += ["friction.coulomb", "gear.stiffness", "housing.frequency"]
    assert [q.name for q in mechanism.free] == names
    amplitude, coulomb = (mechanism.parameters[n] for n in ("stepper.detent.0.amplitude", "friction.coulomb"))
    assert (amplitude.value, amplitude.min, amplitude.max) == (0.0, 0.0, 0.1)
    assert (coulomb.value, coulomb.sigma) == (0.0265, 0.01)


def test_the_back_emf_constant_follows_the_torque_constant(mechanism):
    k_v = mechanism.parameters["stepper.back_emf_constant"]
    assert (k_v.status, k_v.tied_to) == (Status.TIED, "stepper.torque_constant")
    assert mechanism.value("stepper.back_emf_constant") == 0.277


def test_static_friction_left_out_follows_coulomb_friction(changed):
    mechanism = read_mechanism(changed("mechanism.toml", "static = 0.03\n", ""))
    static = mechanism.parameters["friction.static"]
    assert (static.status, static.tied_to) == (Status.TIED, "friction.coulomb")
    assert mechanism.value("friction.static") == mechanism.value("friction.coulomb") == 0.0265
    T_frs, T_frd = (list(map(str, mechanism.plant.parameters)).index(name) for name in ("T_frs", "T_frd"))
    moved = np.flatnonzero(mechanism.kernel_jacobian()["friction.coulomb"])
    np.testing.assert_array_equal(moved, sorted((T_frs, T_frd)))


def test_a_back_emf_constant_of_its_own_is_not_tied(changed):
    path = changed("mechanism.toml", "poles", "back_emf_constant = 0.3\npoles")
    assert read_mechanism(path).parameters["stepper.back_emf_constant"].status is Status.KNOWN


def test_a_default_stands_for_what_is_absent(mechanism):
    shift = mechanism.parameters["stepper.phase_shift_deg"]
    assert (shift.value, shift.status) == (90.0, Status.KNOWN)


def test_without_a_housing_it_is_rigid(changed):
    path = changed("mechanism.toml", "[housing]", "")
    content = path.read_text()
    path.write_text(content[: content.index("gain")])
    mechanism = read_mechanism(path)
    assert mechanism.options == {"assembly": "stepper_gear_mass"}
    assert not any(name.startswith("housing") for name in mechanism.parameters)


def test_the_form_of_the_housing(changed):
    path = changed("mechanism.toml", "gain = 2.0", 'gain = 2.0\nform = "unit_dc"')
    assert read_mechanism(path).options["housing.form"] == "unit_dc"


def test_bounds_that_are_missing_are_the_physical_limits(changed):
    """Truth: a detent's phase is periodic; a resistance cannot be negative."""
    path = changed("mechanism.toml", "{ value = 30.0, min = -180.0, max = 180.0 }", "{ value = 30.0 }")
    changed("mechanism.toml", "{ value = 9.5, min = 5.0, max = 20.0 }", "{ value = 9.5, max = 20.0 }")
    mechanism = read_mechanism(path)
    phase, resistance = (mechanism.parameters[n] for n in ("stepper.detent.0.phase_deg", "stepper.coil_resistance"))
    assert (phase.min, phase.max, phase.is_periodic) == (-180.0, 180.0, True)
    assert (resistance.min, resistance.max) == (0.0, 20.0)


def test_a_periodic_angle_may_start_outside_its_turn(changed):
    """Truth: reported in [-180, 180), it may well lie outside the turn that the file wrote."""
    path = changed("mechanism.toml", "{ value = 30.0, min = -180.0", "{ value = -30.0, min = 0.0")
    path.write_text(path.read_text().replace("max = 180.0", "max = 360.0"))
    assert read_mechanism(path).parameters["stepper.detent.0.phase_deg"].value == -30.0


@pytest.mark.parametrize(
    ("poles", "period", "order"),
    [
        (100, 1.8, 4),
        (100, 3.6, 2),
        (100, 7.2, 1),
        (200, 0.9, 4),
        (100, 1.8 * (1 + 1e-12), 4),
        (100, 14.4, None),
        (100, 1.8001, None),
        (100, -1.8, None),
    ],
)
def test_periods_of_a_detent_per_electrical_period(poles, period, order):
    """Truth: an electrical period is 720/poles degrees of the rotor."""
    assert detent_order(poles, period) == order


def test_what_the_equations_divide_by(mechanism):
    """Truth: the paper's equations: L, R, J_rot, J_m and G stand in denominators, p in the start angle."""
    names = {"poles", "coil_resistance", "coil_inductance", "rotor_inertia"}
    assert divisors(mechanism.plant) == {f"stepper.{n}" for n in names} | {"gear.ratio", "load.inertia"}


def test_a_byte_order_mark_and_carriage_returns_are_read(folder):
    path = folder / "mechanism.toml"
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes().replace(b"\n", b"\r\n"))
    assert read_mechanism(path).value("gear.ratio") == -50.0


REMEDY = "write { value = ..., min = ..., max = ... }"

REFUSED = {  # what is replaced, by what -> the message behind "mechanism.toml: "
    "misspelt key": (
        "stiffness =",
        "stifness =",
        'gear.stifness: unknown key; did you mean "stiffness"?',
    ),
    "key of another table": (
        "ratio = -50",
        "ratio = -50\nviscous = 1.0",
        'gear.viscous: unknown key; did you mean "friction.viscous"?',
    ),
    "key without table": (
        "[stepper]",
        "torque_constant = 0.3\n[stepper]",
        'torque_constant: unknown key; did you mean "stepper.torque_constant"?',
    ),
    "strange key": (
        "inertia = 0.010534",
        "inertia = 0.010534\ncolour = 1",
        "load.colour: unknown key; the keys here are inertia",
    ),
    "misspelt table": ("[gear]", "[gears]", 'gears: unknown table; did you mean "gear"?'),
    "empty unknown table": ("[gear]", "[brake]\n[gear]", "brake: unknown table; the keys here are "),
    "misspelt detent": (
        "[[stepper.detent]]",
        "[[stepper.detents]]",
        'stepper.detents: unknown key; did you mean "detent"?',
    ),
    "unknown key of a detent": (
        "period_deg",
        "priod_deg",
        'stepper.detent.0.priod_deg: unknown key; did you mean "period_deg"?',
    ),
    "unknown key of a parameter": (
        "min = 300.0",
        "mim = 300.0",
        'gear.stiffness.mim: unknown key; did you mean "min"?',
    ),
    "missing key": (
        "damping = 0.48",
        "",
        "gear.damping: missing; write damping under [gear], gear damping at output in N m s/rad",
    ),
    "missing table": (
        "[load]\ninertia = 0.010534",
        "",
        "load.inertia: missing; write inertia under [load], test mass inertia in kg m2",
    ),
    "missing key of a detent": (
        "period_deg = 1.8",
        "",
        "stepper.detent.0.period_deg: missing; write period_deg under [[stepper.detent]], detent period",
    ),
    "missing key without unit": (
        "ratio = -50",
        "",
        "gear.ratio: missing; write ratio under [gear], transmission ratio",
    ),
    "detent in single brackets": (
        "[[stepper.detent]]",
        "[stepper.detent]",
        "stepper.detent: found a table; write each harmonic as a table under [[stepper.detent]]",
    ),
    "table in double brackets": (
        "[load]",
        "[[load]]",
        "load: found tables; write a table, [load]",
    ),
    "value in a unit": (
        "coil_inductance = 0.0229",
        'coil_inductance = "22.9 mH"',
        'stepper.coil_inductance: found "22.9 mH"; write the number alone in H, without quotes',
    ),
    "text for a number without unit": (
        "ratio = -50",
        'ratio = "1:50"',
        'gear.ratio: found "1:50"; write the number alone, without quotes',
    ),
    "boolean": (
        "viscous = 9.74e-4",
        "viscous = true",
        "friction.viscous: found true; write a finite number in N m s/rad",
    ),
    "list": (
        "viscous = 9.74e-4",
        "viscous = [1.0]",
        "friction.viscous: found [1.0]; write a finite number in N m s/rad",
    ),
    "not a number": (
        "viscous = 9.74e-4",
        "viscous = nan",
        "friction.viscous: found nan; write a finite number in N m s/rad",
    ),
    "infinite bound": (
        "max = 5000.0",
        "max = inf",
        "gear.stiffness.max: found inf; write a finite number in N m/rad",
    ),
    "value missing": ("value = 2200.0, ", "", f"gear.stiffness.value: missing; {REMEDY}"),
    "bound without physical limit missing": (
        ", max = 5000.0",
        "",
        f"gear.stiffness.max: missing, and gear stiffness at output has no physical limit there; {REMEDY}",
    ),
    "min above max": (
        "min = 300.0, max = 5000.0",
        "min = 5000.0, max = 300.0",
        "gear.stiffness: min = 5000 is above max = 300; exchange them",
    ),
    "min equal to max": (
        "min = 300.0, max = 5000.0",
        "min = 2200.0, max = 2200.0",
        "gear.stiffness: min and max are both 2200; write the number alone where it is known",
    ),
    "above its bounds": (
        "value = 2200.0",
        "value = 9000.0",
        "gear.stiffness: value = 9000 is above max = 5000; start within the bounds or move them",
    ),
    "below its bounds": (
        "value = 2200.0",
        "value = 200.0",
        "gear.stiffness: value = 200 is below min = 300; start within the bounds or move them",
    ),
    "hertz": (
        "value = 5000.0",
        "value = 888.0",
        "housing.frequency: value = 888 is below min = 2500; start within the bounds or move them; "
        "is it in Hz? it is read in rad/s, write 5579.47",
    ),
    "against physics": (
        "viscous = 9.74e-4",
        "viscous = -1.0",
        "friction.viscous: found -1; viscous friction cannot be below 0 N m s/rad",
    ),
    "bound against physics": (
        "min = 300.0",
        "min = -300.0",
        "gear.stiffness.min: found -300; gear stiffness at output cannot be below 0 N m/rad",
    ),
    "zero in a denominator": (
        "coil_inductance = 0.0229",
        "coil_inductance = 0",
        "stepper.coil_inductance: found 0; the equations divide by it, write another number",
    ),
    "a count to be estimated": (
        "ratio = -50",
        "ratio = { value = 50.0, min = -100.0, max = 100.0 }",
        "gear.ratio: found a table; it shapes the equations and is known, never estimated: write the number alone",
    ),
    "sigma": (
        "sigma = 0.01",
        "sigma = 0.0",
        "friction.coulomb.sigma: found 0; write the prior's standard deviation, above 0, or leave it out",
    ),
    "poles to be estimated": (
        "poles = 100",
        "poles = { value = 100, min = 50, max = 200 }",
        "stepper.poles: found a table; it shapes the equations and is known, never estimated: write the number alone",
    ),
    "period to be estimated": (
        "period_deg = 1.8",
        "period_deg = { value = 1.8, min = 1.0, max = 2.0 }",
        "stepper.detent.0.period_deg: found a table; it shapes the equations and is known, never estimated: "
        "write the number alone in deg",
    ),
    "odd poles": (
        "poles = 100",
        "poles = 99",
        "stepper.poles: found 99; poles come in pairs, write an even whole number",
    ),
    "static below Coulomb": (
        "static = 0.03",
        "static = 0.01",
        "friction.static: 0.01 is below friction.coulomb = 0.0265; static friction is never below "
        "Coulomb friction: start at 0.0265 or above",
    ),
    "unknown assembly": (
        "[stepper]",
        'assembly = "steper_gear_mass"\n[stepper]',
        'assembly: unknown "steper_gear_mass"; did you mean "stepper_gear_mass"?',
    ),
    "assembly of a wrong type": (
        "[stepper]",
        "assembly = 1\n[stepper]",
        'assembly: found 1; write assembly = "stepper_gear_mass", or leave it out',
    ),
    "unknown form": (
        "gain = 2.0",
        'gain = 2.0\nform = "papr"',
        'housing.form: unknown form "papr"; did you mean "paper"?',
    ),
    "form of a wrong type": (
        "gain = 2.0",
        "gain = 2.0\nform = true",
        'housing.form: found true; write form = "paper", or leave it out',
    ),
    "unit behind a number": (
        "coil_inductance = 0.0229",
        "coil_inductance = 22.9 mH",
        "line 6, column 24: expected newline or end of document after a statement, "
        "in 'coil_inductance = 22.9 mH'; write name = value, a number without unit and a text ",
    ),
    "table that is not closed": (
        "max = 5000.0 }",
        "max = 5000.0",
        "line 21, column ",
    ),
    "key twice": (
        "ratio = -50",
        "ratio = -50\nratio = 50",
        "line 21, column 11: cannot overwrite a value, in 'ratio = 50'; ",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_wrong_file_says_where_what_and_the_remedy(name, changed, refused):
    old, new, message = REFUSED[name]
    path = changed("mechanism.toml", old, new)
    refused(f"mechanism.toml: {message}", read_mechanism, path)


def test_a_number_in_place_of_a_table():
    with pytest.raises(InputFileError, match=r"^here: gear: found 5; write a table, \[gear\]$"):
        mechanism_from_table({"gear": 5}, "here")


def test_a_table_that_is_not_closed_is_said_to_need_one_line(changed):
    path = changed("mechanism.toml", "max = 5000.0 }", "max = 5000.0")
    with pytest.raises(InputFileError, match=r"; a table in \{ \} has to stand on one line$"):
        read_mechanism(path)


def test_a_missing_file_and_its_neighbour(folder):
    message = f'{folder / "mechanisn.toml"}: there is no such file; did you mean "mechanism.toml"?'
    with pytest.raises(InputFileError, match=f"^{re.escape(message)}$"):
        read_mechanism(folder / "mechanisn.toml")


def test_a_folder_is_no_mechanism(folder):
    with pytest.raises(InputFileError, match=r"cannot be read \(it is a folder\); check the path$"):
        read_mechanism(folder)


def test_a_file_in_another_encoding(folder):
    (folder / "mechanism.toml").write_bytes("[stepper]\n# 90°\n".encode("latin-1"))
    message = r"^mechanism\.toml: line 2: is not UTF-8 text; save the file as UTF-8$"
    with pytest.raises(InputFileError, match=message):
        read_mechanism(folder / "mechanism.toml")


def test_a_frequency_that_looks_like_hertz_is_asked_about(changed, mechanism):
    path = changed("mechanism.toml", "{ value = 5000.0, min = 2500.0, max = 9000.0 }", "888.0")
    question = "mechanism.toml: housing.frequency = 888: is this in Hz? it is read in rad/s"
    assert mechanism_warnings(read_mechanism(path), path.name) == (question,)
    assert mechanism_warnings(mechanism, path.name) == ()
