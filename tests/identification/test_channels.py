"""Several channels at once. Truth: values that made the records, run by the slow twin, noise added."""

from dataclasses import replace

import numpy as np
import pytest

from channels import FREE, NOISE, OFFSET, written
from csv_files import write_csv
from freed import assert_found, freed
from layouts import SINGLE_STEPPER, changed, mechanism_of, paper_table
from mechid.analysis.validation import validate
from mechid.campaign import load_campaign, mechanism_text
from mechid.campaign.identify_options import IdentifyOptions
from mechid.campaign.prediction import simulate_all
from mechid.campaign.trajectory_file import write_trajectories
from mechid.errors import InputFileError
from mechid.identification.identify import identify, make_problem
from mechid.identification.uncertainty.covariance import Visits
from mechid.records import ChannelSpec, RecordSpec, read_record
from paper import constant
from runs import base, run_twin


def test_all_channels_together_are_identified_from(tmp_path):
    """Each in its own noise, offset removed; what the currents add brings resistance and torque constant down."""
    m = mechanism_of(paper_table())
    truth = {name: m.value(name) for name in FREE}
    campaign = written(tmp_path, m, truth)
    assert campaign.warnings == ()
    fit = identify(campaign)
    assert_found(fit, truth)
    for record in fit.records.values():
        assert list(record.channels) == ["torque", "output_angle", "current_phase_a", "current_phase_b"]
        for quantity, channel in record.channels.items():
            assert channel.residual_rms == pytest.approx(NOISE[quantity], rel=0.1), quantity
            assert channel.offset == pytest.approx(OFFSET[quantity], abs=0.5 * NOISE[quantity] + 1e-3)
            assert (channel.drift is None) == (quantity != "torque")


SCALED = ("stepper.peak_voltage", "stepper.coil_resistance", "stepper.coil_inductance", "stepper.torque_constant")


@pytest.mark.slow
def test_a_current_tells_the_voltage_from_the_coils(tmp_path):
    """Truth: with the torque alone U -> c U, k_m -> c k_m, R and L -> c^2 changes nothing; a current goes as 1/c."""
    m = mechanism_of(changed(paper_table(), {"stepper": {"back_emf_constant": None}}))
    truth = {name: m.value(name) for name in SCALED}
    fit = identify(written(tmp_path, m, truth, quantities=("torque", "current_phase_b")))
    assert_found(fit, truth)
    assert not any("peak_voltage" in note for note in fit.notes)


@pytest.mark.parametrize("keys", [lambda _: "", lambda q: ', use = "validate"' if q != "torque" else ""])
def test_without_a_current_to_estimate_from_the_voltage_is_refused(tmp_path, keys):
    m = mechanism_of(paper_table())
    quantities = ("torque", "output_angle") if not keys("current_phase_b") else ("torque", "current_phase_b")
    campaign = written(tmp_path, m, {name: m.value(name) for name in SCALED}, quantities=quantities, keys=keys)
    with pytest.raises(InputFileError, match="add a channel of a phase current"):
        make_problem(campaign, 1)


def test_a_channel_to_validate_with_is_compared_and_not_fitted(tmp_path):
    """Truth: the fit without it, to the bit; and its noise, which is what the prediction leaves."""
    m = mechanism_of(paper_table())
    truth = {name: m.value(name) for name in ("gear.stiffness", "gear.damping")}
    compared = written(
        tmp_path,
        m,
        truth,
        keys=lambda q: ', use = "validate"' if q == "current_phase_a" else "",
        quantities=("torque", "current_phase_a"),
    )
    fit = identify(compared)
    records = tuple(
        replace(r, matches=tuple(match for match in r.matches if match.quantity == "torque")) for r in compared.records
    )
    alone = identify(replace(compared, records=records))
    assert [p.value for p in fit.parameters.values()] == [p.value for p in alone.parameters.values()]
    current = fit.records["full_46"].channels["current_phase_a"]
    assert current.use == "validate"
    assert current.residual_rms == pytest.approx(NOISE["current_phase_a"], rel=0.1)
    found = validate(compared, fit)["full_46"].channels["current_phase_a"]
    assert found.residual_rms == pytest.approx(current.residual_rms, rel=1e-3)


def test_lost_samples_count_for_nothing(tmp_path):
    """A fifth of the torque lost in bursts: the noise found is that of the others, estimates within their errors."""
    m = mechanism_of(paper_table())
    truth = {name: m.value(name) for name in FREE}
    rng = np.random.default_rng(37)

    def lose(y, quantity):
        for start in rng.integers(300, y.size - 200, 40) if quantity == "torque" else ():
            y[start : start + rng.integers(5, 25)] = np.nan

    more = "conditioning = { max_gap_s = 0.1 }"
    campaign = written(tmp_path, m, truth, quantities=("torque", "current_phase_a"), more=more, change=lose)
    fit = identify(campaign)
    assert_found(fit, truth)
    validation = validate(campaign, fit)
    for name, record in fit.records.items():
        torque, current = record.channels["torque"], record.channels["current_phase_a"]
        assert 0.1 < torque.rejected / record.samples < 0.3
        assert current.rejected == 0
        assert torque.noise_sigma == pytest.approx(NOISE["torque"], rel=0.1)
        judged = validation[name].channels["torque"]
        for found in (torque.residual_rms, judged.residual_rms):
            assert found == pytest.approx(NOISE["torque"], rel=0.05)
        assert judged.whiteness.p_value > 1e-3


def test_simulate_writes_every_channel(tmp_path):
    """Truth: the twin; a file that is written is read as a record of the same channels."""
    m = mechanism_of(paper_table())
    campaign = written(tmp_path, m, {"gear.stiffness": 900.0}, seconds=0.02)
    campaign = replace(campaign, mechanism=replace(m, plant=campaign.mechanism.plant))
    (path, _) = write_trajectories(simulate_all(campaign), tmp_path / "out").values()
    header, *_ = path.read_text().splitlines()
    quantities = tuple(campaign.mechanism.plant.outputs)
    assert header == "time_s,torque_Nm,output_angle_rad,current_phase_a_A,current_phase_b_A"
    twin = run_twin(replace(m, plant=campaign.mechanism.plant), constant(5.0), base(0.02)).y
    spec = tuple(ChannelSpec(quantity=q, column=k) for k, q in enumerate(quantities, 1))
    record = read_record(path, RecordSpec(name="out", path=path.name, channels=spec))
    for k, quantity in enumerate(quantities):
        found = record.channel(quantity).data
        assert np.linalg.norm(found - twin[:, k]) <= 1e-5 * np.linalg.norm(twin[:, k])


COUNTS = 4000
"""Of a turn: 20 a full step."""
STEPPER = {"stepper.torque_constant": 0.384, "friction.viscous": 5e-4, "friction.coulomb": 0.006}


@pytest.fixture(scope="module")
def turned():
    """Return a stepper on a current drive and its rotor angle on two records, rad, at 5 kHz."""
    m = mechanism_of({"assembly": "current_driven_stepper", **SINGLE_STEPPER})
    angle = type(m)(m.plant.with_outputs(("rotor_angle",)), m.parameters, m.options)
    return m, {rate: run_twin(angle, constant(rate), base(0.4, rate_hz=5e3)).y[:, 0] for rate in (5.0, 12.0)}


def counted(folder, turned, zero):
    """Return a campaign of the whole counts of an encoder whose first count begins at `zero` of one."""
    m, angles = turned
    lines = ['mechanism = "mechanism.toml"']
    for rate, angle in angles.items():
        counts = np.floor(angle * COUNTS / (2.0 * np.pi) + zero)
        write_csv(folder / f"{rate:g}.csv", "time_s,counts", np.arange(counts.size) / 5e3, counts)
        channel = f'quantity = "rotor_angle", column = "counts", unit = "rad", gain = {2.0 * np.pi / COUNTS!r}'
        lines += [
            "[[record]]",
            f'name = "at_{rate:g}"',
            f'file = "{rate:g}.csv"',
            f"channels = [{{ {channel}, quantisation = 1 }}]",
            f'command = {{ stepping = "full", rate = {rate}, start_angle_deg = 45.0 }}',
        ]
    lines += ["[[stage]]", f"free = [{', '.join(f'{chr(34)}{name}{chr(34)}' for name in STEPPER)}]"]
    (folder / "campaign.toml").write_text("\n".join(lines) + "\n")
    (folder / "mechanism.toml").write_text(freed(mechanism_text(m), STEPPER, off=1.01))
    return load_campaign(folder)


def test_an_encoder_is_identified_from_with_its_resolution_as_noise(tmp_path, turned):
    """Truth: the values that made it; of a uniform error of one count the standard deviation is 1/sqrt(12)."""
    campaign = counted(tmp_path, turned, 0.37)
    assert campaign.warnings == ()
    fit = identify(campaign)
    assert_found(fit, STEPPER, sigmas=3.0, largest=0.1)
    for record in fit.records.values():
        channel = record.channels["rotor_angle"]
        assert channel.quantisation == pytest.approx(2.0 * np.pi / COUNTS)
        assert channel.noise_sigma == pytest.approx(2.0 * np.pi / COUNTS / np.sqrt(12.0))
        assert channel.residual_rms < 1.1 * channel.noise_sigma
        assert (channel.offset is None, channel.drift is None) == (False, True)
    for name in STEPPER:
        assert fit.parameters[name].std_error > 2.0 * fit.parameters[name].std_error_white


@pytest.mark.slow
def test_rounding_is_not_taken_for_a_stationary_colour(tmp_path, turned):
    """Truth: the rule; a filter that is asked for is there."""
    campaign = replace(counted(tmp_path, turned, 0.61), stages=())
    for colour, whitened in (("auto", False), ("prefilter", True)):
        fit = identify(replace(campaign, options=IdentifyOptions(colour=colour)), near=STEPPER)
        assert all((record.prefilter_order > 0) == whitened for record in fit.records.values())


@pytest.mark.slow
def test_estimates_from_counts_scatter_as_reported(tmp_path_factory, turned):
    """Truth: the scatter of errors over encoder zeros, in reported errors, 1 or less: rounding is never overrated."""
    pulls = []
    for zero in np.random.default_rng(5).random(16):
        fit = identify(counted(tmp_path_factory.mktemp("counted"), turned, zero))
        pulls.append([(fit.parameters[n].value - v) / fit.parameters[n].std_error for n, v in STEPPER.items()])
    spread = np.sqrt(np.mean(np.square(pulls), axis=0))
    assert np.all(spread > 0.4)
    assert np.all(spread < 1.0 + 2.5 / np.sqrt(2.0 * 16))


def test_sums_over_visits_are_those_of_all_rows_at_once():
    """Truth: the rows of each visit summed by hand, whatever the blocks they come in."""
    rng = np.random.default_rng(8)
    measured = np.repeat(rng.integers(0, 3, 40), rng.integers(1, 9, 40)).astype(float)
    rows = rng.standard_normal((measured.size, 2))
    number = np.cumsum(np.concatenate([[0], np.diff(measured) != 0.0]))
    sums = np.stack([rows[number == k].sum(axis=0) for k in range(number[-1] + 1)])
    visits = Visits(measured, 2)
    for part in np.split(rows, [1, 7, 50, 51]):
        visits.add(part)
    np.testing.assert_allclose(visits.total, sums.T @ sums, rtol=1e-12)
