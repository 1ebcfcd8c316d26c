"""Tooth meshes. Truth: the published orders of a solar array drive, and the arithmetic of wheels counted by hand."""

from dataclasses import replace

import numpy as np
import pytest

from layouts import LAYOUTS, changed, paper_with
from mechid.plant.superset import superset_of
from mechid.simulation.simulator import Simulator, simulate_run
from mechid.simulation.start import Start
from paper import constant
from runs import base

SOLAR_ARRAY = {"ratio": 184, "mesh": [{"teeth": [74, 69]}, {"teeth": [75, 80], "ratio_behind": 185}]}
"""The drive of Sentinel-2 behind its motor: wheel 2 (74 teeth) drives 3 (69), 3 (75) drives 4 (80)."""


def test_the_orders_of_a_solar_array_drive_are_the_published_ones():
    """Truth: orders per turn of the array: 13 616 and 14 800 of the meshes; 184, 197.3 and 185 of a wheel's turn."""
    lines = {one.name: one for one in paper_with({"gear": SOLAR_ARRAY}).named_lines}
    found = {name: 184.0 * one.per_turn for name, one in lines.items() if "hunting" not in name}
    assert found == pytest.approx(
        {"mesh 1": 13616, "mesh 1 driver": 184, "mesh 1 driven": 197.333, "mesh 2": 14800, "mesh 2 driven": 185},
        rel=1e-5,
    )
    assert (
        lines["mesh 1 driven"].words
        == "driven wheel of tooth mesh 1 (74:69), and driving wheel of tooth mesh 2 (75:80)"
    )
    assert lines["mesh 1"].order == pytest.approx(74 / 200), "200 full steps a turn of a rotor of 100 poles"


def test_two_teeth_meet_again_after_the_least_common_multiple():
    """Truth: counted: 75 and 80 teeth share 5, so that a pair meets after 1200 teeth, 16 turns of the driver."""
    gear = {"ratio": -50 * 80 / 75, "mesh": [{"ratio_before": 10, "teeth": [75, 80], "ratio_behind": 5}]}
    lines = {one.name: one.per_turn for one in paper_with({"gear": gear}).named_lines}
    assert lines["mesh 1 hunting"] == pytest.approx(0.1 / 16)
    assert lines["mesh 1"] == pytest.approx(7.5), "the driver turns a tenth of what the rotor does"


def test_a_mesh_may_have_kinematic_errors_and_a_varying_stiffness():
    """Truth: the lines of both meshes, each once: wheels on one shaft have one order, which harmonic 1 may have too."""
    terms = {t.name: t for t in superset_of(paper_with({"gear": SOLAR_ARRAY})).terms}
    own = [name for name in terms if "mesh" in name]
    assert own == [
        "gear.kinematic_error:mesh 1",
        "gear.kinematic_error:mesh 1 driven",
        "gear.kinematic_error:mesh 1 hunting",
        "gear.kinematic_error:mesh 2",
        "gear.kinematic_error:mesh 2 driven",
        "gear.kinematic_error:mesh 2 hunting",
        "gear.stiffness_variation:mesh 1",
        "gear.stiffness_variation:mesh 2",
    ]
    words = "kinematic error of the gear: tooth mesh 2 (75:80), 80.4348 per turn of its input"
    assert terms["gear.kinematic_error:mesh 2"].words == words
    grown = superset_of(paper_with({"gear": SOLAR_ARRAY}), grown_only=True)
    assert [t.name for t in grown.terms if "mesh" in t.name] == [n for n in own[:5] if "hunting" not in n]


def test_an_error_that_the_file_has_is_no_candidate():
    """Truth: the layout has the errors of both meshes and the stiffness of the second."""
    names = {t.name for t in superset_of(paper_with(LAYOUTS["tooth mesh"])).terms}
    assert not names & {f"gear.kinematic_error:mesh {k}" for k in (1, 2)}
    assert {n for n in names if n.startswith("gear.stiffness_variation")} == {"gear.stiffness_variation:mesh 1"}


@pytest.mark.slow
def test_a_stiffness_that_varies_with_the_teeth_gains_no_energy():
    """Truth: J w^2/2 + J_l w_l^2/2 + (1 + v) K d^2/2 stays as it began, where nothing drives and nothing rubs."""
    free = {
        "housing": None,
        "friction": {"static": 0.0, "coulomb": 0.0, "viscous": 0.0},
        "stepper": {"torque_constant": 1e-15, "detent": None},
        "gear": {"damping": 0.0},
    }
    m = paper_with(changed(LAYOUTS["tooth mesh"], free))
    m = replace(m, plant=m.plant.with_outputs(("rotor_angle", "rotor_rate", "output_angle", "output_rate")))
    start = Start({"start.rate": 3.0, "start.twist": 2e-4, "start.twist_rate": 0.05})
    simulator = Simulator(m.plant, constant(46.0), base(1.0), start=start)
    angle, rate, output, output_rate = simulate_run(simulator.run(m.kernel_values(), substeps=16)).values.values()

    def harmonic(name):
        order, amplitude, phase_deg = (m.value(f"gear.{name}.{key}") for key in ("order", "amplitude", "phase_deg"))
        return amplitude * np.sin(order * angle + np.radians(phase_deg))

    variation, error = harmonic("stiffness_variation.0"), sum(harmonic(f"kinematic_error.{k}") for k in range(3))
    kinetic = 0.5 * m.value("stepper.rotor_inertia") * rate**2 + 0.5 * m.value("load.inertia") * output_rate**2
    elastic = 0.5 * m.value("gear.stiffness") * (angle / m.value("gear.ratio") + error - output) ** 2
    energy = kinetic + (1.0 + variation) * elastic
    assert np.ptp(variation * elastic) > 1e-3 * energy[0]
    assert np.ptp(energy) < 1e-9 * energy[0]
