"""Linear models and lines of a mechanism on its bench: against closed forms of each stage of the test stand."""

import numpy as np
import pytest

from export_bench import bench_of, stage_response
from layouts import LAYOUTS, changed, mechanism_of, paper_table
from mechid.budgets.bench_to_flight import bench_to_flight
from mechid.budgets.emission import line_sigmas
from mechid.budgets.lines import filter_decay_s
from mechid.budgets.steady_state import cut_off
from mechid.errors import FitError
from mechid.exports.forcing import estimate_on_base, forcing
from mechid.exports.linear.check import departure
from mechid.exports.linear.linear import linear_of
from mechid.exports.linear.options import Options
from mechid.exports.linear.target import AGREES
from mechid.exports.stepping import steppings
from mechid.exports.tables.check import compare_directly
from mechid.exports.tables.history import simulate_history
from mechid.plant.flight import to_flight, with_line_filter
from mechid.simulation.accuracy import simulate_accurately
from mechid.simulation.simulator import Simulator

RATE = 46.0
FREQUENCIES = np.array([0.3, 3.0, 46.0, 250.0, 1500.0])
WHOLE = LAYOUTS["test stand"]
CHAINS = {
    "gain": {"transducer": {"gain": -1.1}},
    "resonance": {"transducer": {"law": "resonance", "frequency": 9000.0, "damping": 0.02}},
    "adaptor": {"transducer": WHOLE["transducer"]},
    "charge amplifier": {"charge_amplifier": {"time_constant": 0.8}},
    "anti-alias, order 2": {"anti_alias": {"frequency": 3000.0, "order": 2}},
    "anti-alias, order 5": {"anti_alias": WHOLE["anti_alias"]},
    "whole chain": WHOLE,
}


def lines_of(handed, *, stand):
    """Return estimate, forcing of full steps, and its steady state at the one rate."""
    estimate = estimate_on_base(handed, stand=stand)
    found = forcing(estimate, steppings(handed.trials)[0], np.array([RATE]))
    return estimate, found, found.largest[0]


def linear(handed, *, stand):
    return linear_of(handed, Options(rates=(), samples=2, stand=stand))


ALONE = set(CHAINS) - {"whole chain"}
"""Single stages, all of which the whole chain has."""


@pytest.fixture(scope="module", params=[pytest.param(c, marks=pytest.mark.slow) if c in ALONE else c for c in CHAINS])
def chain(request, paper):
    """Return a mechanism with a rigid housing and some stages behind it, and the stages' table."""
    return bench_of(paper, {"housing": None, **CHAINS[request.param]}), CHAINS[request.param]


def test_lines_are_those_on_the_base_times_the_stages_response(chain):
    """Truth: closed forms of the stages, at each line's frequency; amplitude and phase."""
    handed, stages = chain
    (_, _, flying), (_, _, bench) = (lines_of(handed, stand=stand) for stand in (False, True))
    loud = np.abs(flying.lines) > 1e-4 * np.abs(flying.lines).max()
    at = np.isin(bench.orders, flying.orders[loud])
    expected = flying.lines[loud] * stage_response(stages, flying.frequency_hz[loud])
    np.testing.assert_allclose(bench.lines[at], expected, rtol=1e-4, atol=1e-8 * np.abs(expected).max())
    assert not np.allclose(bench.lines[at], flying.lines[loud], rtol=1e-4)


@pytest.mark.slow
def test_lines_agree_with_a_direct_simulation_of_the_bench(chain):
    estimate, found, bench = lines_of(chain[0], stand=True)
    lined = with_line_filter(estimate.mechanism, cut_off(found.mode))
    compared = compare_directly(lined, len(estimate.names) + len(lined.plant.states), found)
    assert np.abs(compared.off).max() < 1e-7 * np.abs(bench.lines).max()


def test_the_stages_parameters_are_in_the_error_of_the_lines(chain):
    """Truth: differences of the closed form over each parameter's standard error, of parameters that do not correlate.

    Those of the mechanism itself move the line as they move it on the base, times the response.
    """
    handed, stages = chain
    estimate, _, bench = lines_of(handed, stand=True)
    plain, _, flying = lines_of(handed, stand=False)
    loud, own = int(np.argmax(np.abs(bench.lines))), int(np.argmax(np.abs(flying.lines)))
    line, through = bench.lines[loud], stage_response(stages, bench.frequency_hz[[loud]])[0]
    moved = [
        flying.gradient[own, plain.names.index(name)] * through * handed.std_error(name)
        if name in plain.names
        else flying.lines[own] * _moved(stages, name, handed.std_error(name), bench.frequency_hz[loud])
        for name in estimate.names
    ]
    expected = np.sqrt(sum((np.conj(line) / abs(line) * m).real ** 2 for m in moved))
    assert set(plain.names) < set(estimate.names)
    assert line_sigmas(estimate, bench)[loud] == pytest.approx(expected, rel=1e-4)


def _moved(stages, name, sigma, hertz):
    """Return by how much one standard error of a stage's parameter moves the stages' response."""
    table, key = name.split(".")
    step = 1e-3 * sigma
    ends = [
        stage_response(changed(stages, {table: {key: stages[table].get(key, 1.0) + sign * step}}), np.array([hertz]))[0]
        for sign in (1.0, -1.0)
    ]
    return (ends[0] - ends[1]) / 2e-3


def test_linear_torque_is_that_on_the_base_times_the_stages_response(chain):
    """Truth: closed forms of the stages; no other output passes them."""
    handed, stages = chain
    flying, bench = (linear(handed, stand=stand) for stand in (False, True))
    for name, model in bench.models.items():
        same = [flying[name].inputs.names.index(i) for i in model.inputs.names]
        ours, theirs = model.response(FREQUENCIES), flying[name].response(FREQUENCIES)[:, :, same]
        assert model.outputs.names == flying[name].outputs.names
        torque = model.outputs.names.index("torque")
        through = stage_response(stages, FREQUENCIES)[:, None]
        np.testing.assert_allclose(ours[:, torque], theirs[:, torque] * through, rtol=1e-9, atol=1e-13)
        np.testing.assert_allclose(np.delete(ours, torque, 1), np.delete(theirs, torque, 1), rtol=1e-9, atol=1e-13)


HOUSINGS = {
    "paper": {},
    "unit_dc": {"housing": {"form": "unit_dc"}},
    "second mode": LAYOUTS["second mode"],
    "whole": {**WHOLE, **LAYOUTS["second mode"]},
    "weight": {"housing": None, **LAYOUTS["unbalance"], "transducer": {"gain": 0.9}},
}


QUICK = ("whole", "weight")
"""All stages together, and a stand without a housing."""


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in HOUSINGS]
)
def test_linear_models_follow_the_equations_of_the_bench(paper, name):
    """Truth: the nonlinear equations with the stand's filters; the tolerance of the export."""
    found = linear(bench_of(paper, HOUSINGS[name]), stand=True)
    assert max(departure(found.held, one, model.matrices) for one, model in found.models.items()) < AGREES
    assert all(unit for model in found.models.values() for unit in model.states.units)


def test_derivatives_to_the_stand_s_parameters(paper):
    """Truth: central differences of the matrices, each linearised anew."""
    found = linear(bench_of(paper, {**WHOLE, **LAYOUTS["second mode"]}), stand=True)
    held, model = found.held, found["free"]
    kept = held.moving_states("free")
    stand = [k for k, n in enumerate(model.names) if n.split(".")[0] in ("housing", *WHOLE)]
    assert len(stand) == 12
    for k in stand:
        value = held.opened.mechanism.value(model.names[k])
        step = 1e-5 * abs(value)
        ends = [held.matrices_at("free", {model.names[k]: value + sign * step}, kept) for sign in (1.0, -1.0)]
        for exact, a, b in zip(model.by_parameter[k].all, ends[0].all, ends[1].all, strict=True):
            difference = (a - b) / (2.0 * step)
            size = max(np.abs(difference).max(initial=0.0), 1e-9 * np.abs(a).max(initial=0.0) / step)
            np.testing.assert_allclose(exact, difference, atol=1e-5 * size, err_msg=model.names[k])


@pytest.mark.slow
def test_the_stand_has_settled_where_the_mechanism_rests(paper):
    """Truth: a weight shows through a static stand by its gain; behind a charge amplifier nothing is left of it."""
    weight = {"housing": None, **LAYOUTS["unbalance"]}
    chain = {**CHAINS["adaptor"], **CHAINS["anti-alias, order 5"]}
    plain, static, charged = (
        linear(bench_of(paper, {**weight, **more}), stand=True)["stuck"]
        for more in ({}, chain, {**chain, **CHAINS["charge amplifier"]})
    )
    torque = plain.outputs.names.index("torque")
    assert abs(plain.y[torque]) > 1e-3
    assert static.y[torque] == pytest.approx(-1.1 * plain.y[torque], rel=1e-9)
    assert charged.y[torque] == pytest.approx(0.0, abs=1e-12)


def test_without_a_stand_both_are_the_same(paper):
    """Truth: the very numbers, and the base's acceleration among the inputs."""
    handed = bench_of(paper, {"housing": None})
    flying, bench = (linear(handed, stand=stand) for stand in (False, True))
    assert bench["free"].inputs.names == flying["free"].inputs.names
    assert "base_acceleration" in bench["free"].inputs.names
    np.testing.assert_array_equal(bench["free"].matrices.block_matrix, flying["free"].matrices.block_matrix)
    np.testing.assert_array_equal(*(lines_of(handed, stand=stand)[2].lines for stand in (False, True)))


@pytest.mark.slow
def test_the_history_has_what_the_bench_shows(paper):
    """Truth: the simulation of the mechanism as identified."""
    handed = bench_of(paper, HOUSINGS["whole"])
    mechanism, trial = handed.mechanism, handed.trials[0]
    lined = with_line_filter(to_flight(mechanism, stand=True), 2.0 * np.pi * 500.0)
    found = simulate_history(mechanism, lined, len(lined.plant.states), trial).numeric
    own = simulate_accurately(Simulator(mechanism.plant, trial.command, trial.base), mechanism.kernel_values()).torque
    np.testing.assert_allclose(found["transducer_torque_Nm"], own, atol=1e-5 * np.abs(own).max())
    assert "base_torque_Nm" not in found


def test_a_stand_that_never_settles_is_refused():
    bench = mechanism_of(changed(paper_table(), {"housing": {"damping": 0.0}}))
    with pytest.raises(FitError, match=r"never settles.*damping above 0"):
        filter_decay_s(with_line_filter(to_flight(bench, stand=True), 3000.0))


def test_what_the_fit_left_counts_as_it_is_on_the_bench(paper):
    """Truth: the bench's residual was seen behind the same stand, so that it is carried by 1, and that is known."""
    mechanism = bench_of(paper, HOUSINGS["whole"]).mechanism
    same = bench_to_flight(mechanism, to_flight(mechanism, stand=True))
    frequency = np.array([5.0, 46.0, 300.0, 2000.0])
    np.testing.assert_allclose(same.ratio(frequency), 1.0, rtol=1e-6)
    assert same.paths_agree(frequency).all()
    assert not bench_to_flight(mechanism, to_flight(mechanism)).paths_agree(frequency).all()
