"""Motion that multiplies any difference, told before the search and followed in stretches. Truth: what made it."""

from dataclasses import replace

import numpy as np
import pytest

from complete_benches import Bench, catalogue, noisy
from complete_fits import GEARED
from csv_files import write_csv
from layouts import changed, paper_table
from mechid.campaign import load_campaign, mechanism_text
from mechid.campaign.bench import write_bench
from mechid.command import Command, RateProfile
from mechid.errors import InputFileError
from mechid.identification.identify import identify, make_problem
from mechid.identification.output_error.misfit import misfit_series, misfit_series_of
from mechid.identification.uncertainty.settings import VERDICTS
from mechid.identification.uncertainty.visibility import (
    chaos_warnings,
    count_sensitivities,
    divergence_time_s,
    first_diverged_window,
    start_warnings,
    unseen_parameters,
)
from paper import constant
from runs import base, rms, run_kernel

CHAOTIC = changed(
    paper_table(),
    {
        "load": {"inertia": 0.05765},
        "gear": {"damping": 0.0146},
        "friction": {"static": 0.0451, "coulomb": 0.00898, "viscous": 9.84e-5},
    },
)
"""A lightly damped drive with much stiction under quarter steps: it slips at every step, now longer, now shorter."""
FREE = (*GEARED[2:], "friction.coulomb", "stepper.torque_constant")
STEPS = 'stepping = "micro", microsteps = 4, rate = 66.3, start_angle_deg = 45.0'
COMMAND = Command(stepping="micro", microsteps=4, rate=RateProfile.constant(66.3), start_angle_deg=45.0)
BENCH = Bench(seed=7, table=CHAOTIC, free=FREE)


def campaign(folder, *more, seconds=4.0, exact=True, command=COMMAND, steps=STEPS):
    """Write and read a campaign of one record of the chaotic drive, from its own values or from a catalogue."""
    time_base = base(seconds)
    y = noisy(run_kernel(BENCH.mechanism, command, time_base, substeps=8).torque, "torque", np.random.default_rng(7))
    write_csv(folder / "run.csv", "time_s,torque_Nm", time_base.times, y, fmt="%.12g")
    text = catalogue(BENCH)
    if exact:
        found = mechanism_text(BENCH.mechanism)
        text = found.replace("torque_constant = 0.384", "torque_constant = { value = 0.384, min = 0.2, max = 0.8 }")
        assert text != found
    (folder / "mechanism.toml").write_text(text)
    lines = [
        'mechanism = "mechanism.toml"',
        "[[record]]",
        'name = "run"',
        'file = "run.csv"',
        f"command = {{ {steps} }}",
    ]
    (folder / "campaign.toml").write_text("\n".join([*lines, *more]) + "\n")
    return load_campaign(folder)


def test_it_is_told_before_the_search_how_far_a_record_can_be_followed(tmp_path):
    """Truth: two runs whose torque constants differ by 1e-9, and two by 1e-8, which are apart sooner."""
    made = campaign(tmp_path)
    (line,) = chaos_warnings(made, points=1)
    assert "stretch_s = 0.9" in line
    problem = make_problem(made, 1)
    apart_s = divergence_time_s(problem, problem.targets[0], problem.start)
    p = BENCH.mechanism.kernel_values()
    at = list(map(str, BENCH.mechanism.plant.parameters)).index("k_m")
    own = run_kernel(BENCH.mechanism, COMMAND, base(4.0)).torque
    found = []
    for displaced in (1e-9, 1e-8):
        moved = p.copy()
        moved[at] *= 1.0 + displaced
        off = np.abs(run_kernel(BENCH.mechanism, COMMAND, base(4.0), p=moved).torque - own)
        found.append(np.argmax(off > 2e-3) / 1e4)
        assert rms(off[30000:]) > 0.2 * rms(own)
    assert found[1] < found[0]
    assert apart_s == pytest.approx(found[0], abs=0.4)


def test_a_motion_that_repeats_is_not_told_of(tmp_path):
    made = campaign(tmp_path, command=constant(5.0), steps='stepping = "full", rate = 5.0, start_angle_deg = 45.0')
    assert chaos_warnings(made, points=1) == ()


REJOINING = RateProfile.through([(0.0, 66.018), (3.572, 66.018), (4.572, 115.95), (7.0, 115.95)])
"""The chaotic rate, left just when two runs have come apart: at the higher one the motion repeats itself."""


def test_runs_that_meet_again_are_not_chaotic(tmp_path):
    """Truth: two runs whose parameters differ by 1e-9, which differ by more than the noise once and not at the end."""
    command = replace(COMMAND, rate=REJOINING)
    points = ", ".join(f"[{t}, {r}]" for t, r in zip(REJOINING.times_s, REJOINING.rates, strict=True))
    steps = f'stepping = "micro", microsteps = 4, rate_profile = [{points}], start_angle_deg = 45.0'
    made = campaign(tmp_path, seconds=7.0, command=command, steps=steps)
    problem = make_problem(made, 1)
    target, q = problem.targets[0], problem.start
    size = np.maximum(np.abs(q), 1e-3 * problem.coordinates.span)
    displaced = q + VERDICTS.displacement * size * np.random.default_rng(0).choice([-1.0, 1.0], q.size)
    one, other = (problem.model.predict(target, point, target.samples)[0] for point in (q, displaced))
    off = np.abs(one - other)
    assert off.max() > 2.0 * target.leading.sigma
    assert rms(off[-5000:]) < 1e-3 * rms(one)
    assert divergence_time_s(problem, target, q) is None
    assert chaos_warnings(made, points=1) == ()


@pytest.mark.parametrize(
    ("apart", "first"),
    [
        (np.arange(1000) >= 400, 400),
        ((np.arange(1000) >= 400) & (np.arange(1000) % 20 == 0), 400),
        ((np.arange(1000) >= 400) & (np.arange(1000) < 500), None),
        (np.arange(1000) >= 990, None),
        (np.zeros(1000, dtype=bool), None),
        (np.ones(1000, dtype=bool), None),
    ],
)
def test_runs_are_apart_for_good_where_most_parts_of_the_rest_show_it(apart, first):
    assert first_diverged_window(apart) == first


def test_stretches_are_records_that_begin_where_the_one_before_ends(tmp_path):
    """Truth: the record as a whole."""
    whole = campaign(tmp_path, seconds=1.0).records[0]
    parts = campaign(tmp_path, "stretch_s = 0.3", seconds=1.0).records
    assert [r.name for r in parts] == ["run_1", "run_2", "run_3", "run_4"]
    joined = np.concatenate([r.data.channel("torque").data for r in parts])
    np.testing.assert_array_equal(joined, whole.data.channel("torque").data)
    assert [r.command.start for r in parts] == ["commanded", *["estimated"] * 3]
    assert len(parts[0].start) == 0
    ends = np.cumsum([r.data.samples for r in parts])
    for part, first in zip(parts[1:], ends, strict=False):
        assert part.data.time_start_s == pytest.approx(first / 1e4)
        assert part.command.begun_s == pytest.approx(first / 1e4)
        assert part.start[0].name.startswith(f"record.{part.name}.start.")


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (["stretch_s = 0.0"], "stretch_s: found 0; write the length of a stretch in s, above 0"),
        (["stretch_s = 1e-3"], "stretch_s: found 0.001; a stretch has 64 samples at least"),
        (
            ["stretch_s = 0.05", "[[stage]]", 'free = ["stepper.torque_constant"]'],
            "stretch_s: stages name whole records",
        ),
    ],
)
def test_stretches_that_cannot_be_are_refused(tmp_path, more, message):
    with pytest.raises(InputFileError) as error:
        campaign(tmp_path, *more, seconds=0.1)
    assert message in str(error.value)


@pytest.mark.slow
def test_a_chaotic_record_is_followed_in_stretches_far_beyond_its_horizon(tmp_path):
    """Truth: what made the record of 6 s, whose runs come apart after 1.9 s; the catalogue is some fifth off."""
    fit = identify(campaign(tmp_path, "stretch_s = 1.0", seconds=6.0, exact=False), workers=1)
    assert fit.grade in {"A", "B"}
    for record in fit.records.values():
        assert record.residual_rms == pytest.approx(2e-3, rel=0.05)
    for name, value in BENCH.truth.items():
        p = fit.parameters[name]
        assert abs(p.value - value) < 3.5 * p.std_error, name
        assert p.std_error < 0.01 * value, name


@pytest.mark.parametrize("offset_s", [0.5, 0.50003, 0.4, 0.6144, 0.0001])
def test_a_free_time_offset_may_stand_on_a_sample(tmp_path, offset_s):
    """Truth: an offset between two samples; displaced runs then begin in the same interval."""
    line = f"time_offset_s = {{ value = {offset_s}, min = 0.0, max = 0.7 }}"
    made = campaign(tmp_path, line, seconds=0.9)
    problem = make_problem(made, 1)
    target, q = problem.targets[0], problem.start
    assert divergence_time_s(problem, target, q) is None
    other = q + 1e-7 * (np.array(problem.coordinates.names) == "record.run.time_offset_s")
    pair = misfit_series_of(problem.model, target, [q, other], (0, target.samples))
    for point, (series,) in zip((q, other), pair, strict=True):
        np.testing.assert_array_equal(series[:], misfit_series(problem.model, target, point, (0, target.samples))[0][:])
    assert chaos_warnings(made, points=1) == ()


FREE_OFFSET = "time_offset_s = { value = 0.0, min = -0.002, max = 0.002 }"


@pytest.fixture
def folder(tmp_path):
    write_bench(tmp_path, seed=1, sweep_s=0.1)
    return tmp_path


def change(path, old, new):
    content = path.read_text()
    assert old in content
    path.write_text(content.replace(old, new, 1))


def test_the_bench_sees_all_its_parameters(folder):
    """Also the phase of the detent that starts at zero amplitude, searched as cosine and sine."""
    campaign = load_campaign(folder)
    assert unseen_parameters(campaign) == ()
    assert start_warnings(campaign) == ()


def test_the_phase_of_a_detent_known_to_be_zero_is_unseen(folder):
    change(folder / "mechanism.toml", "amplitude = { value = 0.0, min = 0.0, max = 0.1 }", "amplitude = 0.0")
    assert unseen_parameters(load_campaign(folder)) == ("stepper.detent.1.phase_deg",)


def test_a_mechanism_at_rest_shows_nothing_of_itself(folder):
    """Without a step and without detents the rotor stays where it is and no torque is measured."""
    path = folder / "campaign.toml"
    head, _, _ = path.read_text().partition('\n[[record]]\nname = "full_46"')
    path.write_text(head.replace("rate = 23.0", "rate = 0.0") + FREE_OFFSET + "\n")
    mechanism = folder / "mechanism.toml"
    for old in (
        "amplitude = { value = 0.01, min = 0.0, max = 0.1 }",
        "amplitude = { value = 0.0, min = 0.0, max = 0.1 }",
    ):
        change(mechanism, old, "amplitude = 0.0")
    campaign = load_campaign(folder)
    assert set(unseen_parameters(campaign)) == {q.name for q in campaign.free}
    assert "record.full_23.time_offset_s" in unseen_parameters(campaign)


def test_a_record_for_validation_sees_nothing(folder):
    """The time offset of a record that is not fitted is nobody's to estimate, and is not asked about."""
    path = folder / "campaign.toml"
    path.write_text(path.read_text() + 'use = "validate"\n' + FREE_OFFSET + "\n")
    assert unseen_parameters(load_campaign(folder)) == ()


def test_a_mechanism_that_diverges_is_told_for_each_record(folder):
    change(folder / "mechanism.toml", "inertia = 0.010534", "inertia = 1e-9")
    warnings = [line for line in start_warnings(load_campaign(folder)) if line.startswith("record")]
    assert all("at the values of the mechanism file" in line for line in warnings)
    assert {f'record "full_{rate}"' for rate in (23, 46, 92)} <= {line.partition(" at")[0] for line in warnings}


def test_nothing_free_has_nothing_to_see(folder):
    campaign = load_campaign(folder)
    text = mechanism_text(campaign.mechanism.with_free(()))
    (folder / "mechanism.toml").write_text(text)
    known = load_campaign(folder)
    assert count_sensitivities(known) == 0
    assert start_warnings(known) == ()
