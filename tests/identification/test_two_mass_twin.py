"""A two-mass drive measured on both sides. Truth: values put into a simulator that shares no line with mechid."""

import numpy as np
import pytest

from mechid.analysis import validate
from mechid.campaign import load_campaign
from mechid.identification.identify import identify
from mechid.identification.result.grade import Cause, Grade
from two_mass_twin import NOISE, TRUTH, simulate_two_masses, write_two_masses

RECORDS = {"one": (2.0, 1, "estimate", ""), "two": (2.0, 2, "estimate", ""), "held": (2.0, 3, "validate", "")}
LATE = "time_offset_s = { value = 0.0, min = -0.01, max = 0.01 }"


def identified(folder, records=RECORDS, near=TRUTH, **changes):
    of = load_campaign(write_two_masses(folder, records, **changes))
    return of, identify(of, near=near, workers=1)


def assert_found(fit, truth, sigmas=4.0):
    """Hold values against the truth; the simulator switches its friction a substep late, some 1e-4 of an impulse."""
    for name, value in truth.items():
        p = fit.parameters[name]
        assert p.value == pytest.approx(value, abs=sigmas * p.std_error + 3e-4 * abs(value)), name


def test_the_simulator_swings_as_the_two_masses_do():
    """Truth: sqrt(K (1/J_m + 1/(G^2 J))) of the free masses, 14.5 Hz, from the zero crossings of the winding."""
    free = {**TRUTH, "friction.coulomb": 0.0, "friction.viscous": 0.0, "gear.damping": 0.0}
    torque = np.zeros(2001)
    torque[0] = 1.0
    rotor, output = simulate_two_masses(torque, free)
    wound = rotor / 50.0 - output
    crossings = np.flatnonzero(np.diff(np.sign(wound[100:])) != 0)
    frequency = 1000.0 / (2.0 * np.mean(np.diff(crossings)))
    expected = np.sqrt(4e3 * (1.0 / 1.2 + 1.0 / (50.0**2 * 2e-4))) / (2.0 * np.pi)
    assert frequency == pytest.approx(expected, rel=2e-3)


def test_its_structure_is_found_and_a_record_held_out_is_predicted(tmp_path):
    of, fit = identified(tmp_path)
    assert fit.grade is Grade.A
    assert_found(fit, TRUTH)
    for quantity, channel in validate(of, fit)["held"].channels.items():
        assert channel.residual_rms == pytest.approx(NOISE[quantity], rel=0.06)


@pytest.mark.slow
def test_a_damping_at_its_physical_limit_is_no_contradiction_by_itself(tmp_path):
    """Records that feed the gear's swing, as a delay of a channel does: they want a damping below 0."""
    _, fit = identified(tmp_path, truth={**TRUTH, "gear.damping": -0.15}, near={**TRUTH, "gear.damping": 0.1})
    p = fit.parameters["gear.damping"]
    assert (p.status, p.contradicted, p.at_physical_limit) == ("at_bound", False, True)
    assert p.one_sided[0] == 0.0
    assert 0.0 < p.one_sided[1] < 1.5
    assert fit.grade is Grade.B
    (reason,) = [r for r in fit.reasons if r.cause is Cause.PHYSICAL_LIMIT]
    assert reason.parameter == "gear.damping"
    assert "friction" not in reason.text
    assert_found(fit, {name: value for name, value in TRUTH.items() if name != "gear.damping"}, sigmas=3.0)


@pytest.mark.slow
def test_a_bound_of_the_file_that_excludes_the_truth_stays_contradicted(tmp_path):
    _, fit = identified(tmp_path, least=2.0, near={**TRUTH, "gear.damping": 2.1})
    assert fit.parameters["gear.damping"].contradicted
    assert fit.grade is Grade.C
    (reason,) = [r for r in fit.reasons if r.cause is Cause.BOUND_CONTRADICTED]
    assert reason.next_command.endswith("with a wider range of gear.damping in the mechanism file")


@pytest.mark.slow
def test_the_input_of_a_held_out_record_that_is_late_is_found(tmp_path):
    """Truth: a torque shifted by 4 samples against both angles."""
    records = {**RECORDS, "held": (2.0, 3, "validate", LATE)}
    of, fit = identified(tmp_path, records, torque_late_samples=4.0)
    found = fit.records["held"].nuisance
    own = found.parameters["record.held.time_offset_s"]
    assert own.value == pytest.approx(-0.004, abs=4.0 * own.std_error + 2e-5)
    assert own.std_error < 1e-4
    assert 0.2 <= found.until_s <= 1.0
    for quantity, channel in validate(of, fit)["held"].channels.items():
        assert channel.residual_rms < 3.0 * NOISE[quantity]


@pytest.mark.slow
def test_it_is_found_from_the_values_of_a_data_sheet(tmp_path):
    """A quarter to a factor of two off, no values given: the whole search."""
    of = load_campaign(write_two_masses(tmp_path, RECORDS))
    fit = identify(of)
    assert fit.grade is Grade.A
    assert_found(fit, TRUTH)
