"""Dry friction over the angle, also by direction. Truth: the balance of energy, the twin, and differences."""

from dataclasses import replace

import numpy as np
import pytest

from layouts import LAYOUTS, mechanism_of, paper_with
from mechid.command import InputChannel, MeasuredCommand
from mechid.errors import InputFileError
from mechid.plant.superset import superset_of, words_of
from runs import base, run_kernel, run_twin


def turning_on_uneven_friction(torque, seconds, key="position"):
    """Return a body on friction that varies with its angle, its time base and its command of a constant torque."""
    m = mechanism_of(
        {
            "assembly": "direct_torque_drive",
            "load": {"inertia": 2e-3},
            "drive": {},
            "friction": {
                "coulomb": 0.05,
                "viscous": 0.0,
                key: [{"order": 1, "amplitude": 0.6, "phase_deg": 40.0}],
            },
        }
    )
    time_base = base(seconds, rate_hz=1e3)
    channel = InputChannel(quantity="torque", held=True, samples=np.full(time_base.samples, torque))
    command = MeasuredCommand().driven_by((channel,), 1e3, 0.0)
    return replace(m, plant=m.plant.with_outputs(("output_angle", "output_rate"))), command, time_base


def test_friction_that_varies_with_the_angle_keeps_the_balance_of_energy():
    """Truth: J v^2/2 = (T - T_c) x + T_c A (cos(x + phi) - cos(phi)), the work of a constant torque less friction's."""
    run, phi = run_kernel(*turning_on_uneven_friction(0.09, 0.8), substeps=4).values, np.radians(40.0)
    x, v = run["output_angle"], run["output_rate"]
    assert x[-1] > 2.0
    work = (0.09 - 0.05) * x + 0.05 * 0.6 * (np.cos(x + phi) - np.cos(phi))
    np.testing.assert_allclose(2e-3 * v**2 / 2, work, rtol=0, atol=1e-8 * work.max())
    still = run_kernel(*turning_on_uneven_friction(0.069, 0.1), substeps=4).values
    assert np.all(still["output_angle"] == 0.0), "friction is 0.05 (1 + 0.6 sin 40 deg) = 0.0693 there"


def test_friction_over_the_angle_has_its_derivatives():
    """Truth: the twin's variational equations, and central differences."""
    m, command, time_base = turning_on_uneven_friction(0.09, 0.8)
    chosen = [list(map(str, m.plant.parameters)).index(name) for name in ("T_frd", "c_f1", "s_f1")]
    kernel = run_kernel(m, command, time_base, sensitive=chosen, substeps=8).jacobian["output_angle"]
    twin = run_twin(m, command, time_base, sensitive=chosen).jacobian[:, 0]
    assert np.all(np.linalg.norm(kernel - twin, axis=0) <= 1e-5 * np.linalg.norm(twin, axis=0))
    p = m.kernel_values()
    for j, i in enumerate(chosen):
        step = 1e-6 * np.eye(p.size)[i]
        runs = (run_kernel(m, command, time_base, p=p + way * step, substeps=8).values for way in (1, -1))
        up, down = (run["output_angle"] for run in runs)
        np.testing.assert_allclose((up - down) / 2e-6, kernel[:, j], rtol=0, atol=1e-4 * np.abs(kernel[:, j]).max())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("key", "way"), [pytest.param("position_forward", 1.0, marks=pytest.mark.slow), ("position_backward", -1.0)]
)
def test_friction_by_direction_acts_in_its_direction_alone(key, way):
    """Truth: the balance of energy, and plain Coulomb friction the other way, at rest too."""
    run, phi = run_kernel(*turning_on_uneven_friction(way * 0.09, 0.8, key), substeps=4).values, np.radians(40.0)
    x, v = run["output_angle"], run["output_rate"]
    assert way * x[-1] > 2.0
    work = way * (0.09 - 0.05) * x + way * 0.05 * 0.6 * (np.cos(x + phi) - np.cos(phi))
    np.testing.assert_allclose(2e-3 * v**2 / 2, work, rtol=0, atol=1e-8 * work.max())
    still = run_kernel(*turning_on_uneven_friction(way * 0.069, 0.1, key), substeps=4).values
    assert np.all(still["output_angle"] == 0.0), "friction is 0.05 (1 + 0.6 sin 40 deg) = 0.0693 there"
    other = run_kernel(*turning_on_uneven_friction(-way * 0.069, 0.4, key), substeps=4).values
    energy = (0.069 - 0.05) * np.abs(other["output_angle"])
    np.testing.assert_allclose(2e-3 * other["output_rate"] ** 2 / 2, energy, rtol=0, atol=1e-8 * energy.max())


TABLES = ("friction.position_forward", "friction.position_backward")
SLIDING = {"assembly": "direct_force_drive", "load": {"mass": 95.0}, "drive": {}}
FRICTION = {"static": 15.0, "coulomb": 10.0, "viscous": 3.0}


def test_by_direction_is_tried_where_friction_varies_with_the_angle():
    """Truth: orders 1 and 2 forward; order 1 is in the file already, and without a variation there is no candidate."""
    position = paper_with(LAYOUTS["friction position"])
    words = "dry friction forward alone varies with the angle of the rotor, 2 per turn"
    assert words_of(position)["friction.position:forward:2"] == words
    assert not [name for name in words_of(paper_with({})) if "forward" in name]
    names = {t.name for t in superset_of(paper_with(LAYOUTS["friction by direction"])).terms}
    assert not [name for name in names if "forward" in name], "the file has both"


def test_one_plant_serves_any_order_by_direction():
    """Truth: the digest of the equations; the orders are values."""
    plants = {
        paper_with({"friction": {"position_forward": [{"order": k, "amplitude": 0.1}]}}).plant.digest for k in (1, 7)
    }
    assert len(plants) == 1


@pytest.mark.parametrize("table", TABLES)
def test_an_axis_that_slides_has_no_turn(table):
    key = table.rpartition(".")[2]
    table_of_file = {**SLIDING, "friction": {**FRICTION, key: [{"order": 1, "amplitude": 0.1}]}}
    with pytest.raises(InputFileError, match=f"{table}: is per turn, and this axis slides; delete it"):
        mechanism_of(table_of_file)
