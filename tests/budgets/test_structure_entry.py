"""The structure of a budget file. Truth: the modes read without it, rotations by hand, and a line for each fault."""

import tomllib

import numpy as np
import pytest

from mechid.budgets.example import BUDGET, write_example
from mechid.budgets.structure_entry import COUPLED_BELOW_HZ, read_frame, read_structure_entry
from mechid.campaign.place import Place
from mechid.errors import InputFileError
from mechid.structure import Modes, Structure

PLACE = Place("budget.toml")
FREE = Modes(np.array([0.0, 35.0]), np.array([0.0, 0.01]), np.array([0.3, 0.2]), np.array([[0.3, 0.05]]))


def test_attitude_control_holds_the_rigid_body_of_a_structure_that_is_given():
    """Truth: `Modes.with_attitude_control`, which has tests of its own."""
    given = Structure(name="s", line_of_sight=("x",), model=FREE)
    table = tomllib.loads("[structure]\nattitude_control = { bandwidth_hz = 0.05, damping = 0.7 }")
    held, coupled = read_structure_entry(table, PLACE, None, given)
    at = np.array([0.01, 0.05, 3.0])
    expected = FREE.with_attitude_control(0.05, 0.7)
    np.testing.assert_array_equal(held.model.frequency_hz, expected.frequency_hz)
    np.testing.assert_array_equal(held.model.response(at), expected.response(at))
    assert coupled == COUPLED_BELOW_HZ
    plain, coupled = read_structure_entry({"structure": {"coupled_below_hz": 60.0}}, PLACE, None, given)
    assert plain is given
    assert coupled == 60.0


def test_a_frame_turns_the_bench_into_the_structure():
    """Truth: by hand, a quarter turn about z; without an entry the axes are the same."""
    turned = read_frame({"structure": {"frame": {"x": [0, 1, 0], "y": [-1, 0, 0], "z": [0, 0, 1]}}}, PLACE)
    np.testing.assert_allclose(turned @ [1.0, 2.0, 3.0], [-2.0, 1.0, 3.0], atol=1e-12)
    np.testing.assert_array_equal(read_frame({}, PLACE), np.eye(3))


@pytest.mark.parametrize(
    ("frame", "said"),
    [
        ({"x": [1, 0, 0], "y": [0, 1, 0], "z": [0, 0, -1]}, "the axes are left-handed"),
        ({"x": [1, 0, 0], "y": [0.5, 1, 0], "z": [0, 0, 1]}, "not of length 1 and at right angles"),
        ({"x": [1, 0], "y": [0, 1, 0], "z": [0, 0, 1]}, "structure.frame.x: found [1, 0]; write three cosines"),
        ({"x": [1, 0, 0], "y": [0, 1, 0]}, "structure.frame.z: missing"),
    ],
)
def test_a_frame_that_is_none_is_refused(frame, said):
    with pytest.raises(InputFileError) as caught:
        read_frame({"structure": {"frame": frame}}, PLACE)
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('axis = "rz"', 'axis = "rx"', "describes a torque about rz but the mechanism turns about rx"),
        ("structure.toml", "structur.toml", 'there is no such file; did you mean "structure.toml"'),
        ("bandwidth_hz = 0.02", "bandwith_hz = 0.02", 'did you mean "bandwidth_hz"'),
    ],
)
def test_what_is_wrong_is_said(tmp_path, old, new, said):
    write_example(tmp_path)
    assert old in BUDGET
    with pytest.raises(InputFileError) as caught:
        read_structure_entry(tomllib.loads(BUDGET.replace(old, new, 1)), PLACE, tmp_path)
    assert said in str(caught.value)
    assert str(caught.value).startswith("budget.toml: ")
