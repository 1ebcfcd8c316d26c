"""Linear models at holding: against closed forms, the nonlinear equations in time, differences, and draws."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.stats import binom

from layouts import LAYOUTS, SINGLE_STEPPER, changed, mechanism_of, paper_table
from mechid.command import Command, Excitation, RateProfile
from mechid.errors import FitError
from mechid.exports.linear.check import departure
from mechid.exports.linear.draws import physical_draws
from mechid.exports.linear.fraction import fraction
from mechid.exports.linear.linearisation import HeldMechanism
from mechid.exports.linear.state_space import Uncertain, response_of
from mechid.kernel.equations import equations_of
from mechid.plant.flight import to_flight
from mechid.plant.small_signal import small_signal
from mechid.simulation.simulator import Simulator, TimeBase

NAMES = (
    "stepper.coil_resistance",
    "stepper.coil_inductance",
    "stepper.torque_constant",
    "stepper.detent.0.amplitude",
    "stepper.detent.1.phase_deg",
    "friction.viscous",
    "gear.stiffness",
    "gear.damping",
)
RESTS = Command(stepping="full", microsteps=1, rate=RateProfile.constant(0.0), start_angle_deg=20.0)
"""Off the detents' own rest, so that the equilibrium moves with the parameters."""
INPUTS = ("added_voltage_phase_a", "added_voltage_phase_b", "output_torque", "base_acceleration")
FREQUENCIES = np.array([3.0, 30.0, 46.0, 90.0, 250.0])


def flying(changes=None, table=None):
    """Return a mechanism in flight."""
    own = table or changed(paper_table(), {"housing": None, "stepper": {"back_emf_constant": None}, **(changes or {})})
    return to_flight(mechanism_of(own))


def held_of(mechanism, names=(), relative=2e-3, seed=4):
    """Return a mechanism that holds, its uncertain parameters correlated at random."""
    values = np.array([mechanism.value(n) for n in names])
    root = np.random.default_rng(seed).normal(size=(len(names), len(names) + 3))
    covariance = root @ root.T
    sigma = relative * np.abs(values) / np.sqrt(np.diag(covariance))
    units = tuple(mechanism.plant.declarations[n].unit for n in names)
    uncertain = Uncertain(tuple(names), units, values, covariance * np.outer(sigma, sigma))
    return HeldMechanism(small_signal(mechanism), RESTS, uncertain)


@pytest.fixture(scope="module")
def held():
    """Return the paper's mechanism in flight, with some parameters uncertain."""
    return held_of(flying(), NAMES)


@pytest.fixture(scope="module")
def models(held):
    """Return its models, with 500 draws."""
    return held.models(500, seed=11)


def test_names_and_units(models):
    """Truth: the list of the paper's states and quantities; what friction holds is no state."""
    stuck, free = models["stuck"], models["free"]
    assert list(models) == ["stuck", "free"]
    assert stuck.states.names == ("current_phase_a", "current_phase_b", "output_angle", "output_rate")
    assert free.states.names == (
        "current_phase_a",
        "current_phase_b",
        "rotor_angle",
        "rotor_rate",
        "output_angle",
        "output_rate",
    )
    assert free.states.units == ("A", "A", "rad", "rad/s", "rad", "rad/s")
    assert dict(zip(free.inputs.names, free.inputs.units, strict=True)) == dict(
        zip(INPUTS, ("V", "V", "N*m", "rad/s2"), strict=True)
    )
    assert dict(zip(free.outputs.names, free.outputs.units, strict=True)) == {
        "torque": "N*m",
        "rotor_angle": "rad",
        "rotor_rate": "rad/s",
        "output_angle": "rad",
        "output_rate": "rad/s",
        "current_phase_a": "A",
        "current_phase_b": "A",
        "output_acceleration": "rad/s2",
    }


def test_stuck_in_closed_form(models):
    """Truth: coils at rest are R and L; the load swings on the gear, and what the gear bears is on the base."""
    s = 2j * np.pi * FREQUENCIES
    gear = 913.47 + 0.39 * s
    H = models["stuck"].response(FREQUENCIES)
    out = models["stuck"].outputs.names.index
    np.testing.assert_allclose(H[:, out("current_phase_a"), 0], 1.0 / (9.9 + 0.045 * s), rtol=1e-12)
    np.testing.assert_allclose(H[:, out("torque"), 2], gear / (gear + 0.010534 * s**2), rtol=1e-12)
    np.testing.assert_allclose(H[:, out("output_angle"), 2], 1.0 / (gear + 0.010534 * s**2), rtol=1e-12)
    np.testing.assert_allclose(H[:, out("output_acceleration"), 2], s**2 / (gear + 0.010534 * s**2), rtol=1e-9)
    turned = -0.010534 * gear / (gear + 0.010534 * s**2) - 8.9e-6
    np.testing.assert_allclose(H[:, out("torque"), 3], turned, rtol=1e-9)
    assert not H[:, out("rotor_angle")].any()


def test_what_a_voltage_holds_in_closed_form(models):
    """Truth: at low frequency a free rotor goes where the torque of the changed currents meets that of all springs."""
    free = models["free"]
    angle, k_m, half_p = free.y[free.outputs.names.index("rotor_angle")], 0.384, 50.0
    i_a, i_b = (free.y[free.outputs.names.index(f"current_phase_{x}")] for x in "ab")
    coils = k_m * half_p * (i_a * np.cos(half_p * angle) - i_b * np.sin(half_p * angle))
    detents = ((4, 0.0047, 35.0), (2, 0.0231, -110.0))
    slope = coils - sum(a * n * half_p * np.cos(n * half_p * angle + np.radians(phase)) for n, a, phase in detents)
    per_volt = k_m * np.sin(half_p * angle) / 9.9 / -slope
    H = free.response([1e-3])[0, free.outputs.names.index("rotor_angle"), 0]
    assert H.real == pytest.approx(per_volt, rel=1e-6)
    assert slope < 0.0


def stepped_sine(held, model, place, hertz, amplitude, settle_s):
    """Return the outputs' phasors per unit of an input, by integration of the nonlinear equations from rest."""
    plant, about = held.plant, held.about(model.name)
    equations, p = equations_of(plant), about.p.tolist()
    modes = [about.holding[s] for s in equations.rates.arguments[2]]
    column = [s.name for s in plant.inputs].index(model.inputs.names[place])

    def inputs(t):
        u = about.inputs.copy()
        u[column] += amplitude * np.cos(2.0 * np.pi * hertz * t)
        return u.tolist()

    def flow(t, x):
        return equations.rates(x.tolist(), inputs(t), modes, p)

    times = np.ceil(settle_s * hertz) / hertz + np.arange(80) / 40.0 / hertz
    run = solve_ivp(flow, (0.0, times[-1]), about.x, method="LSODA", t_eval=times, rtol=1e-10, atol=1e-13)
    y = [equations.outputs(x.tolist(), inputs(t), modes, p) for t, x in zip(times, run.y.T, strict=True)]
    columns = np.column_stack([np.cos(2 * np.pi * hertz * times), -np.sin(2 * np.pi * hertz * times), np.ones(80)])
    a, b, _ = np.linalg.lstsq(columns, np.array(y), rcond=None)[0]
    return (a + 1j * b) / amplitude


@pytest.mark.parametrize("name", ["stuck", "free"])
def test_the_response_is_that_of_a_stepped_sine(held, models, name):
    """Truth: the nonlinear equations from rest, a small sine until only that is left: 0.5 %."""
    model = models[name]
    for place, (hertz, amplitude) in enumerate(((12.0, 0.01), (60.0, 0.02), (30.0, 0.002), (100.0, 0.2))):
        got = stepped_sine(held, model, place, hertz, amplitude, settle_s=0.7)
        expected = model.response([hertz])[0, : got.size, place]
        large = np.abs(expected) > 1e-6 * np.abs(expected).max()
        assert large.sum() >= (1 if name == "stuck" and place < 2 else 3)
        np.testing.assert_allclose(got[large], expected[large], rtol=5e-3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changes", "name"),
    [
        ({}, "stuck"),
        ({"friction": {"static": 0.0, "coulomb": 0.0}}, "free"),
        ({"load": LAYOUTS["flexible load"]["load"]}, "stuck"),
    ],
)
def test_the_response_is_that_of_the_simulated_mechanism(changes, name):
    """Truth: the compiled kernel with its switches, a torque on the output in steps of 50 us: 0.5 %."""
    held = held_of(flying(changes))
    model, plant, hertz, amplitude, rate = held.models(0, 0)[name], held.plant, 37.0, 2e-3, 20_000.0
    place = [s.name for s in plant.inputs].index("output_torque")
    seconds = round(1.2 * hertz) / hertz
    times = np.arange(1, int(seconds * rate)) / rate
    values = np.tile(held.inputs, (times.size, 1))
    values[:, place] = amplitude * np.cos(2.0 * np.pi * hertz * times)
    first = held.inputs.copy()
    first[place] = amplitude
    driven = Excitation(first, times, values, tuple(s.name for s in plant.inputs))
    command = replace(RESTS, start="equilibrium")
    base = TimeBase(10_000.0, int(seconds * 10_000.0))
    made = Simulator(plant, command, base, known_edges=driven)
    blocks = [block.y.copy() for block in made.run(held.opened.mechanism.kernel_values(), substeps=4).blocks()]
    t, y = base.times, np.concatenate(blocks)
    last = t >= seconds - 10.0 / hertz
    columns = np.column_stack([np.cos(2 * np.pi * hertz * t), -np.sin(2 * np.pi * hertz * t), np.ones(t.size)])[last]
    a, b, _ = np.linalg.lstsq(columns, y[last], rcond=None)[0]
    lag = np.pi * hertz / rate
    given = amplitude * np.sinc(hertz / rate) * np.exp(-1j * lag)
    got, expected = (
        (a + 1j * b) / given,
        model.response([hertz])[0, : y.shape[1], model.inputs.names.index("output_torque")],
    )
    large = np.abs(expected) > 1e-6 * np.abs(expected).max()
    np.testing.assert_allclose(got[large], expected[large], rtol=5e-3)


@pytest.mark.parametrize(
    "layout",
    [
        "paper",
        "lugre",
        "alone",
        *(
            pytest.param(name, marks=pytest.mark.slow)
            for name in (
                "kinematic_error",
                "flexible load",
                "imbalance",
                "supply",
                "current limit",
                "backlash",
                "output_friction",
                "cable",
                "piecewise_linear",
                "load_dependent",
                "microstep table",
            )
        ),
    ],
)
def test_models_of_the_block_library_are_those_of_their_equations(layout):
    """Truth: the nonlinear equations over one period of a small sine."""
    table = {"assembly": "current_driven_stepper", **SINGLE_STEPPER} if layout == "alone" else None
    held = held_of(flying(LAYOUTS.get(layout, {}), table))
    for name, model in held.models(0, 0).items():
        assert departure(held, name, model.matrices) < 1e-4
        assert np.isfinite(model.response(FREQUENCIES)).all()


def test_a_wrong_matrix_is_seen(held, models):
    """Truth: the check is for this: a stiffness that is off by 0.1 %."""
    A = models["stuck"].matrices.A.copy()
    A[3, 2] *= 1.001
    wrong = replace(models["stuck"].matrices, A=A)
    assert departure(held, "stuck", wrong) > 5e-4


def test_ways_to_hold():
    """Truth: where the load rubs too it can be locked; bristles hold as they are, without a switch."""
    rubbed = held_of(flying(LAYOUTS["output_friction"])).models(0, 0)
    assert list(rubbed) == ["stuck", "locked", "free"]
    assert rubbed["locked"].states.names == ("current_phase_a", "current_phase_b")
    assert rubbed["locked"].margins.keys() == {"friction", "output_friction"}
    assert list(held_of(flying(LAYOUTS["lugre"])).models(0, 0)) == ["holding"]


def test_limits_of_the_supply_and_of_friction(models):
    """Truth: phase A holds -U cos 20 deg; friction at rest without torque holds all of its static level."""
    low, high = models["stuck"].limits["added_voltage_phase_a"]
    held_volts = -5.7 * np.cos(np.radians(20.0))
    assert (low, high) == (pytest.approx(-5.7 - held_volts), pytest.approx(5.7 - held_volts))
    assert models["stuck"].margins == {"friction": pytest.approx(0.008, rel=1e-9)}
    assert models["free"].margins == {}


def test_derivatives_to_every_parameter(held):
    """Truth: central differences of the matrices, each linearised anew where the mechanism then rests."""
    mechanism = held.opened.mechanism
    for name, model in held.models(0, 0).items():
        kept = held.moving_states(name)
        for k, parameter in enumerate(model.names):
            value = mechanism.value(parameter)
            step = 1e-5 * (abs(value) or 1e-2)
            ends = [held.matrices_at(name, {parameter: value + sign * step}, kept) for sign in (1.0, -1.0)]
            for exact, a, b in zip(model.by_parameter[k].all, ends[0].all, ends[1].all, strict=True):
                difference = (a - b) / (2.0 * step)
                size = max(np.abs(difference).max(initial=0.0), 1e-9 * np.abs(a).max(initial=0.0) / step)
                np.testing.assert_allclose(exact, difference, atol=1e-5 * size, err_msg=parameter)


def test_the_equilibrium_moves_along(held, models):
    """Truth: with the rotor left where it was the derivatives of the motor's stiffness are others, and wrong."""
    about, free = held.about("free"), models["free"]
    still = replace(about, x_by_parameter=np.zeros_like(about.x_by_parameter)).by_parameter[0]
    moved = held.opened.mechanism.kernel_jacobian()
    row, column = free.states.names.index("rotor_rate"), free.states.names.index("rotor_angle")
    places = held.moving_states("free")
    shares = {}
    for k, name in enumerate(free.names):
        direct = np.tensordot(moved[name], still, axes=1)[places[row], places[column]]
        exact = free.by_parameter.A[k][row, column]
        shares[name] = abs(exact - direct) / max(abs(exact), 1e-300)
    assert max(shares.values()) > 0.05, shares


@pytest.mark.parametrize("name", ["stuck", "free"])
def test_the_band_holds_what_it_promises(models, name):
    """Truth: 500 draws of the parameters, each linearised anew: two sigma hold 95.45 %, one sigma 68.27 %."""
    model = models[name]
    here, sigma = np.abs(model.response(FREQUENCIES)), model.amplitude_sigma(FREQUENCIES)
    drawn = np.array([np.abs(response_of(model.samples[k], FREQUENCIES)) for k in range(500)])
    told = sigma > 1e-9 * here.max(axis=(0, 2), keepdims=True)
    assert told.sum() > 40
    off = np.abs(drawn - here)[:, told] / sigma[told]
    for sigmas, share in ((2.0, 0.9545), (1.0, 0.6827)):
        inside = np.sum(off <= sigmas, axis=0)
        low, high = binom.ppf([1e-4, 1.0 - 1e-4], 500, share)
        assert inside.min() >= low
        assert inside.max() <= high
        assert np.mean(inside) / 500 == pytest.approx(share, abs=0.02)


def test_draws_are_seeded_and_physical(held):
    """Truth: the covariance's own scatter; values below their limits are drawn anew."""
    again, other = held.models(3, seed=11)["free"], held.models(3, seed=12)["free"]
    assert np.array_equal(again.draws, held.models(3, seed=11)["free"].draws)
    assert not np.array_equal(again.draws, other.draws)
    mechanism = held.opened.mechanism
    many = physical_draws(mechanism, held.uncertain, 4000, 3)
    sigma = held.uncertain.std_errors
    scatter = (np.cov(many.T) - held.uncertain.covariance) / np.outer(sigma, sigma)
    assert np.abs(scatter).max() < 5.0 * np.sqrt(2.0 / 4000)
    wide = Uncertain(("gear.damping",), ("N m s/rad",), np.array([0.39]), np.array([[1.0]]))
    assert physical_draws(mechanism, wide, 500, 0).min() >= 0.0
    nowhere = Uncertain(("gear.damping",), ("N m s/rad",), np.array([-50.0]), np.array([[1.0]]))
    with pytest.raises(FitError, match="fewer than one in 100 draws"):
        physical_draws(mechanism, nowhere, 20, 0)


@pytest.mark.parametrize("name", ["stuck", "free"])
def test_a_linear_fraction_is_the_model_and_its_derivatives(models, name):
    """Truth: the matrices plus derivatives times what the deltas move; the covariance of the matrices' elements."""
    model, parts = models[name], fraction(models[name])
    deltas = np.random.default_rng(2).normal(size=parts.sizes.size)
    slopes, whole = model.by_uncertain.block_matrix, model.matrices.block_matrix
    moved = np.tensordot(parts.directions @ deltas, slopes, axes=1)
    size = np.sqrt(np.outer(np.abs(whole).max(axis=1), np.abs(whole).max(axis=0))) + 1e-12
    assert np.abs((parts.at(deltas).block_matrix - whole - moved) / size).max() < 1e-9
    scaled = (slopes / size).reshape(len(slopes), -1)
    exact = scaled.T @ model.uncertain.covariance @ scaled
    kept = scaled.T @ parts.directions
    np.testing.assert_allclose(kept @ kept.T, exact, atol=1e-9 * np.abs(exact).max())
    assert parts.sizes.size == {"stuck": 4, "free": 8}[name]
