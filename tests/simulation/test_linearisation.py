"""The plant linearised where it holds, against closed forms, differences, and the equations driven in time."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from layouts import LAYOUTS, changed, mechanism_of, paper_table
from mechid.kernel.equations import equations_of
from mechid.plant.flight import to_flight, with_base
from mechid.plant.layout import Base, Flying
from mechid.plant.moving_base import ACCELERATION
from mechid.simulation.linearisation import held_inputs, holdings, linearise
from mechid.simulation.resonances import resonances

WING = {
    "gear": {"stiffness": 6.0e4, "damping": 20.0},
    "load": {"inertia": 35.0, "mode": [{"frequency": np.pi, "damping": 0.005, "inertia": 30.0}]},
}
"""A load of 35 kg m2 of which 30 are in a mode of 0.5 Hz."""


def driven(changes):
    """Return a mechanism in flight whose base is driven."""
    held = to_flight(mechanism_of(changed(paper_table(), {"housing": None, **changes})))
    return with_base(held, Flying(base=Base.DRIVEN))


def about(mechanism, holding, p=None):
    plant = mechanism.plant
    return linearise(plant, mechanism.kernel_values() if p is None else p, held_inputs(plant), 0.0, holding)


def stiffness(mechanism, holding, frequency):
    """Return torque on the base per base angle."""
    response = about(mechanism, holding).response(frequency)[:, 0, mechanism.plant.inputs.index(ACCELERATION)]
    return -((2.0 * np.pi * frequency) ** 2) * response


def test_a_wing_on_a_gear():
    """Truth: the closed form of rotor held, gear and a load with one cantilever mode on a base that turns."""
    f = np.array([0.3, 0.5, 5.0])
    w, mechanism = 2.0 * np.pi * f, driven(WING)
    w1 = np.pi
    load = 5.0 + 30.0 * (w1**2 + 2j * 0.005 * w1 * w) / (w1**2 - w**2 + 2j * 0.005 * w1 * w)
    gear = 6.0e4 + 20.0j * w
    expected = w**2 * (load * gear / (gear - w**2 * load) + 8.9e-6)
    got = stiffness(mechanism, holdings(mechanism.plant)[0], f)
    np.testing.assert_allclose(got, expected, rtol=1e-9)
    gain = np.abs(got / (1000.0 * w**2))  # a free body of 1000 kg m2
    np.testing.assert_allclose(gain, [0.052, 2.70, 0.005], rtol=0.03)


@pytest.mark.slow
@pytest.mark.parametrize(
    "layout",
    [
        "flexible load",
        *(
            pytest.param(n, marks=pytest.mark.slow)
            for n in ("kinematic_error", "lugre", "output_friction", "imbalance")
        ),
    ],
)
def test_the_response_is_that_of_the_equations_driven_in_time(layout):
    """Truth: the nonlinear equations with a base that swings by little, integrated until only that is left: 1 %."""
    mechanism = driven(LAYOUTS[layout])
    plant, p = mechanism.plant, mechanism.kernel_values()
    equations, at = equations_of(plant), plant.inputs.index(ACCELERATION)
    for holding in (holdings(plant)[0], holdings(plant)[-1]):
        point = about(mechanism, holding)
        modes = [holding[s] for s in equations._others[1]]
        f, amplitude = 20.0, 1e-3

        def inputs(t, f=f, amplitude=amplitude):
            u = held_inputs(plant)
            u[at] = amplitude * np.cos(2.0 * np.pi * f * t)
            return u.tolist()

        def flow(t, x, modes=modes, inputs=inputs):
            return equations.rates(x.tolist(), inputs(t), modes, p.tolist())

        times = 3.0 + np.arange(400) / 400.0 / f * 4.0
        run = solve_ivp(flow, (0.0, times[-1]), point.x, method="LSODA", t_eval=times, rtol=1e-8, atol=1e-12)
        y = [
            equations.outputs(x.tolist(), inputs(t), modes, p.tolist())[0] for t, x in zip(times, run.y.T, strict=True)
        ]
        columns = np.column_stack([np.cos(2 * np.pi * f * times), -np.sin(2 * np.pi * f * times), np.ones(times.size)])
        a, b, _ = np.linalg.lstsq(columns, np.array(y), rcond=None)[0]
        expected = point.response(np.array([f]))[0, 0, at]
        assert abs((a + 1j * b) / amplitude - expected) < 0.01 * abs(expected)


def test_derivatives_to_the_parameters():
    """Truth: central differences of the response, over every parameter and both ways to hold."""
    mechanism, f = driven(LAYOUTS["flexible load"]), np.array([3.0, 30.0, 46.0])
    p = mechanism.kernel_values()
    for holding in holdings(mechanism.plant):
        exact = about(mechanism, holding).response_by_parameter(f)
        for k in range(p.size):
            step = 1e-4 * max(abs(p[k]), 1e-3)
            ends = [about(mechanism, holding, p + s * np.eye(p.size)[k]).response(f) for s in (step, -step)]
            difference = (ends[0] - ends[1]) / (2.0 * step)
            size = max(np.abs(exact[k]).max(), 1e-3 * np.abs(ends[0]).max() / max(abs(p[k]), 1e-3))
            np.testing.assert_allclose(
                exact[k], difference, atol=2e-3 * size, err_msg=str(mechanism.plant.parameters[k])
            )


def test_resonances_by_name():
    """Truth: sqrt(K_s/J_m) and the housing's omega_0 of the paper; a stepper alone has none."""
    found = {r.name: r.frequency_hz for r in resonances(mechanism_of(paper_table()))}
    assert found["load on the gear"] == pytest.approx(np.sqrt(913.47 / 0.010534) / (2.0 * np.pi), rel=1e-9)
    assert found["housing"] == pytest.approx(5578.0 / (2.0 * np.pi), rel=1e-9)
    assert len(found) == 2


def test_resonances_of_a_load_with_modes():
    """Truth: the eigenvalues of hub, mode and gear written as a mass and a stiffness matrix."""
    flexible = {"mode": [{"frequency": 190.0, "damping": 0.0, "inertia": 0.003}]}
    changes = {"load": flexible, "gear": {"damping": 1e-9}, "housing": None}
    mechanism = mechanism_of(changed(paper_table(), changes))
    M = np.array([[0.010534, 0.003], [0.003, 0.003]])  # hub angle, the mode's deflection
    K = np.diag([913.47, 0.003 * 190.0**2])
    expected = np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(M, K)))) / (2.0 * np.pi)
    got = resonances(mechanism)
    np.testing.assert_allclose([r.frequency_hz for r in got], expected, rtol=1e-6)
    assert {r.name for r in got} <= {"load on the gear", "load mode 1"}
