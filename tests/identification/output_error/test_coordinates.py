"""What records have of their own beside a time offset: clock, supply, resistance. Truth: differences, and a simulator
that shares no code with the model."""

import re
from dataclasses import replace

import numpy as np
import pytest

from incomplete.benches import drawn
from incomplete.recording import Run, recorded
from mechid.campaign import load_campaign, mechanism_text
from mechid.campaign.campaign import CLOCK
from mechid.campaign.prediction import simulate
from mechid.checks.numbers import check_numbers
from mechid.errors import InputFileError
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import target_of
from mechid.parameter import Parameter, Status
from mechid.plant.superset import with_tables
from runs import rms
from synthetic import COMMANDS, displaced, measured, record, truth

FREE = {"stepper.coil_resistance": 1.03, "stepper.torque_constant": 0.98, "gear.stiffness": 0.98}
PPM = 300.0
CAMPAIGN = """
mechanism = "mechanism.toml"
clock_ppm = {{ value = -120.0, min = -500.0, max = 500.0 }}
[[record]]
name = "a"
command = {{ stepping = "full", rate = 46.0 }}
{a}
[[record]]
name = "b"
command = {{ stepping = "full", rate = 23.0 }}
{b}
"""


def free(name, value, sigma, declaration, replaces=""):
    return Parameter(
        name=name,
        value=value,
        declaration=declaration,
        min=value - 5 * sigma,
        max=value + 5 * sigma,
        sigma=sigma,
        status=Status.FREE,
        replaces=replaces,
    )


@pytest.fixture(scope="module")
def problem():
    """Return two records that share a clock, each with a supply and a resistance of its own, all free."""
    mechanism, rng = displaced(truth(), FREE), np.random.default_rng(3)
    shared, declared, targets = free("campaign.clock_ppm", 40.0, PPM, CLOCK), mechanism.plant.declarations, []
    for k, name in enumerate(("full_46", "micro_46")):
        one = target_of(record(name, measured(truth(), COMMANDS[name], rng, seconds=0.3), COMMANDS[name]))
        own = [shared]
        for key, dotted, sigma in (
            ("peak_voltage", "stepper.peak_voltage", 0.1),
            ("coil_resistance", "stepper.coil_resistance", 0.3),
        ):
            value = mechanism.value(dotted) * (1.0 + 0.01 * k)
            own.append(free(f"record.{name}.{key}", value, sigma, declared[dotted], dotted))
        targets.append(one.add_parameters(*own))
    priors = {p.name: (p.value, p.sigma) for t in targets for p in t.free_parameters}
    return Problem(SearchSpace(mechanism), tuple(targets), priors)


def test_what_records_share_is_one_coordinate(problem):
    """Truth: the names of what is free."""
    assert problem.coordinates.record_parameter_names == (
        "campaign.clock_ppm",
        "record.full_46.peak_voltage",
        "record.full_46.coil_resistance",
        "record.micro_46.peak_voltage",
        "record.micro_46.coil_resistance",
    )


def test_derivatives_are_those_of_differences(problem):
    """Truth: central differences of whole runs, at two widths."""
    at, q = problem.coordinates, problem.start
    widths = {"clock_ppm": 20.0, "peak_voltage": 1e-4, "coil_resistance": 1e-4}
    for target in problem.targets:
        run = problem.model.run(target, q, target.samples, jacobian=True)
        J = np.vstack([at.block_slopes(target, 0, b, b.stop - b.start).copy() for b in run.blocks()])
        for j, name in enumerate(at.record_parameter_names, problem.space.size):
            for width in (widths[name.rpartition(".")[2]], 0.3 * widths[name.rpartition(".")[2]]):
                step = width * np.eye(problem.size)[j]
                low, high = (problem.model.predict(target, q + s * step, target.samples)[0] for s in (-1, 1))
                expected = (high - low) / (2.0 * width)
                assert rms(J[:, j] - expected) <= 2e-4 * rms(expected), (target.name, name, width)
            elsewhere = name.startswith("record.") and target.name not in name
            assert np.any(J[:, j]) != elsewhere
    assert problem.coordinates.lanes == problem.space.size + 2  # clocks share one; the resistances' own lane is idle


def test_a_mean_over_the_records_is_the_mechanisms(problem):
    """Truth: rows by hand. The supply is known, the resistance free, which is what a prior of it is around."""
    q = problem.start
    away, J = problem.coordinates.prior_rows(q)
    names = list(problem.coordinates.names)
    supply, resistance = 5.7, problem.space.mechanism.value("stepper.coil_resistance")
    expected = [0.0, 0.0, 0.0, 0.0, 0.0, 0.005 * supply / (1e-3 * 0.1), 0.005 * resistance / (1e-3 * 0.3)]
    np.testing.assert_allclose(away, expected, rtol=1e-9, atol=1e-9)
    for row in J[[2, 4, 6]]:
        assert row[names.index("stepper.coil_resistance")] < 0.0
    np.testing.assert_allclose(J[2, names.index("stepper.coil_resistance")], -resistance / 0.3)
    assert np.count_nonzero(J[5]) == 2


def test_a_mean_that_the_records_tell_is_held_as_loosely_as_one_value():
    """Truth: rows by hand: a gain's mean within the 3 % of each, a supply's a thousandth of its own, unknown."""
    mechanism, rng = with_tables(displaced(truth(), FREE), ("transducer",)), np.random.default_rng(3)
    declared, targets, far = mechanism.plant.declarations, [], {}
    for name in ("full_46", "micro_46", "full_23"):
        one = target_of(record(name, measured(truth(), COMMANDS[name], rng, seconds=0.1), COMMANDS[name]))
        gain = free(f"record.{name}.transducer.gain", 1.0, 0.03, declared["transducer.gain"], "transducer.gain")
        supply = free(f"record.{name}.peak_voltage", 5.7, 0.1, declared["stepper.peak_voltage"], "stepper.peak_voltage")
        targets.append(one.add_parameters(gain, supply))
        far |= {gain.name: 1.02, supply.name: mechanism.value("stepper.peak_voltage") + 0.02}
    priors = {p.name: (p.value, p.sigma) for t in targets for p in t.free_parameters}
    coordinates = Problem(SearchSpace(mechanism), tuple(targets), priors).coordinates
    gains, supplies = coordinates.means
    assert (gains.of, gains.is_determined, gains.sigma) == ("transducer.gain", True, 0.03)
    assert (supplies.of, supplies.is_determined) == ("stepper.peak_voltage", False)
    assert supplies.sigma == pytest.approx(1e-3 * 0.1)
    start = Problem(SearchSpace(mechanism), tuple(targets), priors).start
    q = coordinates.point(coordinates.values(start) | far)
    rows = coordinates.prior_rows(q)[0]
    assert sorted(rows[-2:]) == pytest.approx([0.02 / 0.03, 0.02 / 1e-4])
    assert len(coordinates.undetermined_means(q)) == 1, "what the records tell adds nothing unseen to the errors"


@pytest.mark.parametrize("ppm", [-450.0, 300.0])
@pytest.mark.parametrize("right", ["driver", "recorder"])
def test_a_clock_is_that_of_an_independent_simulator(tmp_path, ppm, right):
    """Truth: a simulator of its own, whose recorder takes its samples too often, or whose driver steps too soon."""
    mechanism, _ = drawn("clock", 1)
    command = {"stepping": "full", "rate": 46.0, "start_angle_deg": 45.0}
    size = {"driver_ppm": ppm} if right == "recorder" else {"clock_ppm": 1e6 / (1.0 + 1e-6 * ppm) - 1e6}
    true = recorded(mechanism, size, Run(command, 2.0), None)
    (tmp_path / "mechanism.toml").write_text(mechanism_text(mechanism))
    text = (
        f'mechanism = "mechanism.toml"\nclock_reference = "{right}"\n[[record]]\nname = "a"\n'
        'command = { stepping = "full", rate = 46.0, start_angle_deg = 45.0 }\n'
    )
    (tmp_path / "campaign.toml").write_text(text)
    without = simulate(load_campaign(tmp_path, read_records=False), sample_rate_hz=1e4, duration_s=2.0).torque
    (tmp_path / "campaign.toml").write_text(f"{text}clock_ppm = {ppm}\n")
    found = simulate(load_campaign(tmp_path, read_records=False), sample_rate_hz=1e4, duration_s=2.0).torque
    assert rms(found - true.torque_Nm) < 2e-5 * rms(true.torque_Nm)
    assert rms(without - true.torque_Nm) > 1e-2 * rms(true.torque_Nm)


def loaded(folder, a="", b="", more=""):
    (folder / "mechanism.toml").write_text(mechanism_text(truth()))
    (folder / "campaign.toml").write_text(CAMPAIGN.format(a=a, b=b) + more)
    return load_campaign(folder, read_records=False)


@pytest.mark.parametrize("above", [True, False])
@pytest.mark.parametrize("reference", ["recorder", "driver"])
def test_a_file_says_whose_clock_is_right(tmp_path, reference, above):
    """Truth: the default is the recorder's; above the records, or where a fit's finding is declared."""
    plain = loaded(tmp_path)
    assert plain.clock_reference is None
    assert {r.clock_reference for r in plain.records} == {"recorder"}
    line = f'clock_reference = "{reference}"\n'
    made = loaded(tmp_path, more="" if above else f"[[campaign]]\n{line}")
    if above:
        file = tmp_path / "campaign.toml"
        file.write_text(line + file.read_text())
        made = load_campaign(tmp_path, read_records=False)
    assert made.clock_reference == reference
    assert {r.timing.reference for r in made.records} == {reference}


def test_a_file_says_it_for_all_records_and_for_one(tmp_path):
    """Truth: what was written; a record's own clock goes before that of all."""
    campaign = loaded(tmp_path, a="clock_ppm = 30.0\npeak_voltage = 5.5")
    assert [q.name for q in campaign.record("a").parameters] == [
        "record.a.time_offset_s",
        "record.a.clock_ppm",
        "record.a.peak_voltage",
    ]
    assert campaign.record("a").timing.clock_ppm == 30.0
    assert campaign.record("b").clock is campaign.parameters["campaign.clock_ppm"]
    (line,) = [one for one in check_numbers(campaign)["records"][0]["lines"] if "of its own" in one]
    assert line == "of its own: peak_voltage = 5.5"
    apart = loaded(
        tmp_path, more='[[own]]\nrecord = "a"\nclock_ppm = 30.0\n[[own]]\nrecord = "a"\npeak_voltage = 5.5\n'
    )
    assert apart.record("a").parameters == campaign.record("a").parameters
    low, high = (simulate(one, "b", sample_rate_hz=1e4, duration_s=0.3).torque for one in (campaign, apart))
    np.testing.assert_array_equal(low, high)
    own = simulate(campaign, "a", sample_rate_hz=1e4, duration_s=0.3).torque
    assert rms(own - simulate(loaded(tmp_path), "a", sample_rate_hz=1e4, duration_s=0.3).torque) > 1e-3


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ({"a": "peak_voltage = -1.0"}, "record[0].peak_voltage: found -1; peak phase voltage cannot be below 0 V"),
        ({"a": "peak_current = 0.6"}, "record[0].peak_current: the mechanism has no such parameter"),
        ({"b": "clock_ppm = 2e5"}, "record[1].clock_ppm: found 200000; by how much"),
        ({"more": "[[campaign]]\nclock_reference = 'lab'"}, 'clock_reference: found "lab"'),
        ({"more": "[[campaign]]\nclock_ppm = 3.0"}, "campaign[0].clock_ppm: it is written elsewhere in the file too"),
        ({"more": "[[campaign]]\nclock = 3.0"}, "campaign[0].clock: unknown key"),
        ({"more": "[[own]]\nrecord = 'c'"}, 'own[0].record: no record "c"'),
        ({"more": "[[own]]\npeak_voltage = 3.0"}, "own[0].record: missing"),
        ({"more": "[[own]]\nrecord = 'a'\nfile = 'x.csv'"}, "own[0].file: unknown key"),
    ],
)
def test_a_wrong_entry_is_refused_with_its_place(tmp_path, text, message):
    """Truth: the place and the words."""
    with pytest.raises(InputFileError, match=re.escape(message)):
        loaded(tmp_path, **text)


def test_a_clock_reaches_over_all_edges(problem):
    """Truth: the same record with edges for a minute more."""
    target = problem.targets[0]
    q = np.where([n.endswith("clock_ppm") for n in problem.coordinates.names], 5 * PPM, problem.start)
    longer = replace(target, excitation=target.command.excitation(60.0))
    short, long = (problem.model.predict(t, q, t.samples)[0] for t in (target, longer))
    np.testing.assert_array_equal(short, long)
