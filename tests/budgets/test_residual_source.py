"""What the model lacks flies: lines left out of it, against the mechanism that has them; noise, which is no source."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from layouts import paper_with
from mechid.analysis.residual_emission import TRACKED, residual_emission
from mechid.analysis.residual_file import FORMAT, ResidualRecord, read_residual
from mechid.budgets.bench_to_flight import BenchToFlight, bench_to_flight
from mechid.budgets.discrepancy import Discrepancy
from mechid.budgets.emission import UPPER, WITHIN, emission
from mechid.budgets.ensemble import make_ensemble
from mechid.budgets.flight_entry import Flight
from mechid.budgets.flying_mechanism import flying_estimate
from mechid.budgets.indices import Index
from mechid.budgets.line_of_sight import respond
from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.requirement import Requirement
from mechid.budgets.residual_source import ResidualSource
from mechid.budgets.standing import RESIDUAL, assess_standing
from mechid.budgets.steady_state import enough_substeps, steady_state
from mechid.command import Command, RateProfile
from mechid.errors import InputFileError
from mechid.identification.result.fit_file import read_fit
from mechid.plant.flight import to_flight
from mechid.simulation.accuracy import simulate_accurately
from mechid.simulation.simulator import Simulator, TimeBase
from mechid.structure import Modes, Structure
from paper_estimate import write_estimate_of_paper

SAMPLE_RATE_HZ, SIGMA, SECONDS = 5000.0, 2e-3, 2.0
LEFT_OUT = "stepper.detent.1.amplitude"
RATES, FLYING = (18.0, 19.5, 22.5, 24.0), 21.0
STRUCTURE = Structure(
    name="s",
    line_of_sight=("x",),
    model=Modes(np.array([5.0]), np.array([0.7]), np.array([1.0]), np.array([[1.0]])),
)


def micro(rate):
    return Command(stepping="micro", microsteps=16, rate=RateProfile.constant(rate))


def record(residual, rate, name="r", mains_hz=None):
    travel = rate * np.arange(residual.size) / SAMPLE_RATE_HZ
    found = residual_emission(residual, travel, SAMPLE_RATE_HZ, mains_hz)
    return ResidualRecord(
        name=name, stepping="micro", microsteps=16, noise_sigma=SIGMA, sample_rate_hz=SAMPLE_RATE_HZ, rates=found
    )


def white(rng, seconds=SECONDS):
    return SIGMA * rng.normal(size=round(seconds * SAMPLE_RATE_HZ))


def lines(amplitude, order, rate):
    return amplitude * np.cos(2.0 * np.pi * order * rate * np.arange(round(SECONDS * SAMPLE_RATE_HZ)) / SAMPLE_RATE_HZ)


@pytest.fixture(scope="module")
def estimate(tmp_path_factory):
    """Return where the estimate of the paper's mechanism is, without the detent that is left out."""
    path = write_estimate_of_paper(tmp_path_factory.mktemp("estimate"))
    return path, read_fit(path).mechanism


@pytest.fixture(scope="module")
def flying(estimate):
    read = flying_estimate(read_fit(estimate[0]), Flight())
    return replace(read, discrepancy=Discrepancy(of_profiles_alone=True))


def steady(mechanism, names=()):
    mode = OperatingMode(name="m", command=micro(FLYING), rates=np.array([FLYING]), highest_hz=200.0)
    return steady_state(mechanism, mode, FLYING, names, enough_substeps(mechanism, mode, names))


def at_base(flying, source, state):
    here = None if source is None else source.at(micro(FLYING), FLYING)
    return respond(state, STRUCTURE, here, 200.0)


def measured(mechanism, rate):
    """Return the bench's torque of a mechanism from rest, behind its transient."""
    base = TimeBase(SAMPLE_RATE_HZ, round((SECONDS + 1.0) * SAMPLE_RATE_HZ))
    run = simulate_accurately(Simulator(mechanism.plant, micro(rate), base), mechanism.kernel_values())
    return run.torque[-round(SECONDS * SAMPLE_RATE_HZ) :]


def test_a_detent_left_out_of_the_model_flies(estimate, flying):
    """Truth: the flying mechanism that has it, at a rate between those of the bench.

    A fifth of a detent is missing. At each order the model's difference to the truth is within the source's stated
    spread, and no line is above its bound.
    """
    _, bench = estimate
    true_bench = bench.with_values({LEFT_OUT: 1.2 * bench.value(LEFT_OUT)})
    true_flying = flying.mechanism.with_values({LEFT_OUT: 1.2 * flying.mechanism.value(LEFT_OUT)})
    rng = np.random.default_rng(0)
    records = [
        record(measured(true_bench, rate) - measured(bench, rate) + white(rng), rate, f"r{rate}") for rate in RATES
    ]
    source = ResidualSource(tuple(records), bench_to_flight(bench, flying.mechanism))
    state, truth = steady(flying.mechanism, flying.names), steady(true_flying)
    known = replace(flying, covariance=np.zeros_like(flying.covariance))
    found = emission(at_base(flying, source, state), known, 200.0, 0)
    n = state.lines.size
    assert (truth.step_orders[:n] == state.step_orders).all()
    lacking = np.abs(truth.lines - state.lines)
    heard, largest = found.residual[:n] > 0.0, int(np.argmax(lacking))
    assert heard.sum() >= 3
    assert found.residual[largest] == pytest.approx(lacking[largest], rel=0.4)
    low, high = np.sqrt(stats.f.ppf((0.005, 0.995), 2, 2 * len(RATES)))  # of |E| over its root mean square
    ratio = lacking[heard] / found.residual[:n][heard]
    assert np.all((ratio > low) & (ratio < high))
    assert found.bound[largest] >= abs(truth.lines[largest])
    loud = np.abs(truth.lines) > 0.01 * np.abs(truth.lines).max()
    assert np.mean(found.bound[:n][loud] >= np.abs(truth.lines)[loud]) >= 0.95
    assert np.median(found.bound[:n][loud] / np.abs(truth.lines)[loud]) < 1.5


def test_mains_hum_does_not_fly_and_a_line_beside_it_does():
    """Truth: hum of 50.02 Hz, 2.5 times one of the rates, and a line at order 3/4 which every rate has."""
    rng, rates = np.random.default_rng(2), (18.0, 50.02 / 2.5, 22.5, 24.0)
    hum = sum(lines(1.46e-3 / k, 1.0, k * 50.02) for k in (1, 2, 3))
    humming = [white(rng) + hum + lines(1e-3, 0.75, rate) for rate in rates]

    def flies(mains_hz):
        records = tuple(record(r, rate, mains_hz=mains_hz) for r, rate in zip(humming, rates, strict=True))
        return ResidualSource(records, BenchToFlight(None)).at(micro(20.0), 20.0)

    before, after = flies(None), flies(50.02)
    at = {order: TRACKED.index(order) for order in (0.75, 2.5)}
    assert before.amplitude[at[2.5]] > 5e-4
    assert np.flatnonzero(after.amplitude).tolist() == [at[0.75]]
    assert after.amplitude[at[0.75]] == pytest.approx(1e-3, rel=0.1)
    assert before.density.any()
    assert not after.density.any()


def test_a_line_where_the_model_has_none(flying):
    """Truth: 1 mN m at order 3/4, which a motion that repeats after two steps has no line at."""
    rng = np.random.default_rng(1)
    records = tuple(record(white(rng) + lines(1e-3, 0.75, rate), rate) for rate in RATES)
    source = ResidualSource(records, BenchToFlight(None))
    found = emission(at_base(flying, source, steady(flying.mechanism, flying.names)), flying, 200.0, 0)
    (at,) = np.flatnonzero(found.orders == 0.75)
    assert found.modelled[at] == 0.0
    assert found.residual[at] == pytest.approx(1e-3, rel=0.1)
    assert found.residual[at] < found.bound[at] < 3.0 * found.residual[at]
    assert found.transfer_rules[at] == UPPER
    band = np.flatnonzero((found.bands_hz[:, 0] <= 0.75 * FLYING) & (found.bands_hz[:, 1] > 0.75 * FLYING))[0]
    assert found.band_residual[band] == pytest.approx(1e-3 / np.sqrt(2.0), rel=0.1)
    assert WITHIN in found.transfer_rules


def test_noise_alone_makes_a_source_at_one_rate_in_a_hundred_at_most():
    """Truth: 60 sets of records of noise alone; the stated false alarm is 1 %."""
    rng = np.random.default_rng(2)
    alarms = 0
    for _ in range(60):
        records = tuple(record(white(rng, 1.0), rate) for rate in (20.0, 22.0))
        here = ResidualSource(records, BenchToFlight(None)).at(micro(FLYING), FLYING)
        alarms += here.any
        assert here.any or not here.limit.any()
    assert alarms <= 3  # 0.6 are expected; more than 3 happen in 3 of 1000


def requirement():
    return Requirement(
        name="r",
        index=Index("APE"),
        axis="x",
        limit_rad=1e-2,
        interpretation="temporal",
        confidence=0.95,
        evaluation_period_s=10.0,
    )


@pytest.mark.slow
def test_a_complete_model_has_the_budget_that_it_had(flying):
    """Truth: the standing without residual records; white noise alone is left of these."""
    rng = np.random.default_rng(3)
    source = ResidualSource(tuple(record(white(rng), rate) for rate in RATES), BenchToFlight(None))
    state, nobody = steady(flying.mechanism, flying.names), make_ensemble((), np.zeros(0), (), seed=0)
    with_it, without = (
        assess_standing(requirement(), "m", [(1.0, at_base(flying, one, state))], flying, nobody)
        for one in (source, None)
    )
    assert with_it == without
    assert with_it.residual_rad == 0.0


def test_a_model_that_lacks_something_has_a_wider_budget(flying):
    """Truth: the same mechanism, parameters and errors; one line was left of its records."""
    rng = np.random.default_rng(4)
    source = ResidualSource(tuple(record(white(rng) + lines(5e-3, 1.0, r), r) for r in RATES), BenchToFlight(None))
    state, nobody = steady(flying.mechanism, flying.names), make_ensemble((), np.zeros(0), (), seed=0)
    wide, narrow = (
        assess_standing(requirement(), "m", [(1.0, at_base(flying, one, state))], flying, nobody)
        for one in (source, None)
    )
    assert wide.level.value > narrow.level.value
    assert wide.level.sigma > narrow.level.sigma
    assert wide.margin95[0] < narrow.margin95[0]
    assert wide.residual_rad > 0.0
    assert wide.level.shares[RESIDUAL] > 0.0
    assert sum(wide.level.shares.values()) == pytest.approx(1.0)


def test_the_level_of_a_line_that_the_model_lacks_alone(flying):
    """Truth: Gaussian of the line's RMS behind the structure's transfer, with a mechanism that makes nothing."""
    rng = np.random.default_rng(5)
    source = ResidualSource(tuple(record(white(rng) + lines(0.02, 1.0, r), r) for r in RATES), BenchToFlight(None))
    state = steady(flying.mechanism, flying.names)
    silent = replace(state, lines=0.0 * state.lines, gradient=0.0 * state.gradient)
    nobody = make_ensemble((), np.zeros(0), (), seed=0)
    got = assess_standing(requirement(), "m", [(1.0, at_base(flying, source, silent))], flying, nobody)
    transfer = abs(STRUCTURE.to_line_of_sight(np.array([FLYING]))[0, 0])
    assert got.nominal_rad == pytest.approx(1.96 * transfer * 0.02 / np.sqrt(2.0), rel=0.05)


def test_it_grows_outside_the_rates_of_the_bench_and_says_so():
    rng = np.random.default_rng(6)
    source = ResidualSource(tuple(record(white(rng) + lines(5e-3, 1.0, r), r) for r in RATES), BenchToFlight(None))
    near, far = source.at(micro(23.0), 23.0), source.at(micro(48.0), 48.0)
    at = TRACKED.index(1.0)
    assert not near.outside
    assert far.outside
    assert far.amplitude[at] / near.amplitude[at] == pytest.approx(4.0, rel=0.1)
    full = Command(stepping="full", microsteps=1, rate=RateProfile.constant(23.0))
    assert not source.has_same_stepping(full)
    assert source.at(full, 23.0).amplitude[at] > 0.0


def test_the_way_from_the_rotor(estimate, flying):
    """Truth: the same plant on the bench as in flight; the paper's housing lets 4.6 of the rotor's reaction through."""
    _, bench = estimate
    same = bench_to_flight(flying.mechanism, flying.mechanism)
    frequency = np.array([1.0, 20.0, 46.0, 100.0, 300.0])
    assert same.ratio(frequency) == pytest.approx(1.0)
    assert same.paths_agree(frequency).all()
    found = bench_to_flight(bench, flying.mechanism)
    assert (found.ratio(frequency) >= 1.0).all()
    assert not found.paths_agree(np.array([300.0]))[0]
    assert not BenchToFlight(None).paths_agree(frequency).any()


def test_the_way_from_the_rotor_past_open_coils():
    """Truth: the same plant on the bench as in flight; coils that are open at rest pass no input on."""
    bench = paper_with({"stepper": {"pulses": {"on_s": 0.005, "clamp_V": 2.0}}, "housing": None})
    same = bench_to_flight(bench, to_flight(bench, stand=True))
    assert same.ratio(np.array([1.0, 20.0, 300.0])) == pytest.approx(1.0)
    assert same.at_rotor is not None


def test_of_another_fit_it_is_refused(estimate, tmp_path):
    fit = replace(read_fit(estimate[0]), folder=tmp_path)
    assert read_residual(fit) is None
    own = {"format": FORMAT, "orders": list(TRACKED), "records": {}, "provenance": fit.provenance}
    (tmp_path / "residual.json").write_text(json.dumps(own), encoding="utf-8")
    assert read_residual(fit) == ()
    for wrong, says in (
        ({"provenance": {}}, "is of another fit"),
        ({"orders": []}, "another version"),
        ({"records": {"a": {}}}, "is damaged at 'stepping'"),
    ):
        (tmp_path / "residual.json").write_text(json.dumps({**own, **wrong}), encoding="utf-8")
        with pytest.raises(InputFileError, match=says):
            read_residual(fit)
    (tmp_path / "residual.json").write_text("{", encoding="utf-8")
    with pytest.raises(InputFileError, match="is damaged"):
        read_residual(fit)
