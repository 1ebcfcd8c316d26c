"""The mechanism file, and what stands for what it leaves out. Truth: the declarations of the blocks, the file."""

import numpy as np
import pytest

from mechid.campaign import load_mechanism
from mechid.campaign.mechanism_file import mechanism_warnings
from mechid.campaign.mechanism_structure import divisors
from mechid.parameter import Status
from mechid.plant.detent import detent_order


@pytest.fixture
def mechanism(folder):
    return load_mechanism(folder / "mechanism.toml")


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
    mechanism = load_mechanism(changed("mechanism.toml", "static = 0.03\n", ""))
    static = mechanism.parameters["friction.static"]
    assert (static.status, static.tied_to) == (Status.TIED, "friction.coulomb")
    assert mechanism.value("friction.static") == mechanism.value("friction.coulomb") == 0.0265
    T_frs, T_frd = (list(map(str, mechanism.plant.parameters)).index(name) for name in ("T_frs", "T_frd"))
    moved = np.flatnonzero(mechanism.kernel_jacobian()["friction.coulomb"])
    np.testing.assert_array_equal(moved, sorted((T_frs, T_frd)))


def test_a_back_emf_constant_of_its_own_is_not_tied(changed):
    path = changed("mechanism.toml", "poles", "back_emf_constant = 0.3\npoles")
    assert load_mechanism(path).parameters["stepper.back_emf_constant"].status is Status.KNOWN


def test_a_default_stands_for_what_is_absent(mechanism):
    shift = mechanism.parameters["stepper.phase_shift_deg"]
    assert (shift.value, shift.status) == (90.0, Status.KNOWN)


def test_without_a_housing_it_is_rigid(changed):
    path = changed("mechanism.toml", "[housing]", "")
    content = path.read_text()
    path.write_text(content[: content.index("gain")])
    mechanism = load_mechanism(path)
    assert mechanism.options == {"assembly": "stepper_gear_mass"}
    assert not any(name.startswith("housing") for name in mechanism.parameters)


def test_the_form_of_the_housing(changed):
    path = changed("mechanism.toml", "gain = 2.0", 'gain = 2.0\nform = "unit_dc"')
    assert load_mechanism(path).options["housing.form"] == "unit_dc"


def test_bounds_that_are_missing_are_the_physical_limits(changed):
    """Truth: a detent's phase is periodic; a resistance cannot be negative."""
    path = changed("mechanism.toml", "{ value = 30.0, min = -180.0, max = 180.0 }", "{ value = 30.0 }")
    changed("mechanism.toml", "{ value = 9.5, min = 5.0, max = 20.0 }", "{ value = 9.5, max = 20.0 }")
    mechanism = load_mechanism(path)
    phase, resistance = (mechanism.parameters[n] for n in ("stepper.detent.0.phase_deg", "stepper.coil_resistance"))
    assert (phase.min, phase.max, phase.is_periodic) == (-180.0, 180.0, True)
    assert (resistance.min, resistance.max) == (0.0, 20.0)


def test_a_periodic_angle_may_start_outside_its_turn(changed):
    """Truth: reported in [-180, 180), it may well lie outside the turn that the file wrote."""
    path = changed("mechanism.toml", "{ value = 30.0, min = -180.0", "{ value = -30.0, min = 0.0")
    path.write_text(path.read_text().replace("max = 180.0", "max = 360.0"))
    assert load_mechanism(path).parameters["stepper.detent.0.phase_deg"].value == -30.0


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
    assert load_mechanism(path).value("gear.ratio") == -50.0


def test_a_frequency_that_looks_like_hertz_is_asked_about(changed, mechanism):
    path = changed("mechanism.toml", "{ value = 5000.0, min = 2500.0, max = 9000.0 }", "888.0")
    question = "mechanism.toml: housing.frequency = 888: is this in Hz? it is read in rad/s"
    assert mechanism_warnings(load_mechanism(path), path.name) == (question,)
    assert mechanism_warnings(mechanism, path.name) == ()


@pytest.mark.parametrize("value", ["2.0", "48"])
def test_a_damping_ratio_that_looks_like_percent_is_asked_about(changed, value):
    path = changed("mechanism.toml", "damping = 0.05", f"damping = {value}")
    (asked,) = mechanism_warnings(load_mechanism(path), path.name)
    assert asked.startswith(f"mechanism.toml: housing.damping = {float(value):g}: is this in percent?")
    assert asked.endswith(f"write {0.01 * float(value):g} for {float(value):g} %")


def test_a_load_mode_is_asked_about_where_its_damping_is_that_of_no_structure(folder):
    path = folder / "mechanism.toml"
    mode = "\n[[load.mode]]\nfrequency = 30.0\ndamping = 0.5\ninertia = 0.01\n"
    path.write_text(path.read_text(encoding="utf-8") + mode, encoding="utf-8")
    (asked,) = mechanism_warnings(load_mechanism(path), path.name)
    assert asked.startswith("mechanism.toml: load.mode.0.damping = 0.5: is this in percent?")
