"""Commands: what they excite, and each way a campaign's table can be wrong."""

import math
import re

import numpy as np
import pytest

from mechid.command import Command, RateProfile
from mechid.errors import InputFileError, UsageError

WHERE = "campaign.toml: record[0].command"


def from_table(table, folder):
    return Command.from_table(table, WHERE, folder)


def test_full_steps_from_45_degrees(tmp_path):
    """Truth: 46 edges a second; the voltages of 45, 135, 225 deg are +-sqrt(1/2)."""
    command = from_table({"stepping": "full", "rate": 46.0, "start_angle_deg": 45.0}, tmp_path)
    excitation = command.excitation(1.0)
    assert excitation.inputs == ("e_A", "e_B")
    half = math.sqrt(0.5)
    np.testing.assert_allclose(excitation.initial, [-half, half], rtol=1e-15)
    np.testing.assert_allclose(excitation.values[:2], [[half, half], [half, -half]], rtol=1e-15)
    np.testing.assert_allclose(excitation.times, np.arange(1, 47) / 46.0, rtol=1e-15)


@pytest.mark.parametrize("rate", [30.0, -30.0])
def test_voltages_belong_to_their_instants(tmp_path, rate):
    """Truth: at an edge theta is theta_0 plus 90 deg times the integral of the rate."""
    table = {"stepping": "micro", "microsteps": 16, "rate": rate, "start_angle_deg": 10}
    excitation = from_table(table, tmp_path).excitation(0.5)
    theta = np.deg2rad(10.0 + 90.0 * rate * excitation.times)
    assert excitation.times.size == 240
    np.testing.assert_allclose(excitation.values, np.stack([-np.cos(theta), np.sin(theta)], axis=1), atol=1e-13)


@pytest.mark.parametrize("rate", [0.0, 46.0])
def test_arrays_are_as_a_kernel_takes_them(rate):
    """Truth: the contract: C-contiguous float64, also where there is no edge."""
    excitation = Command(stepping="full", microsteps=1, rate=RateProfile.constant(rate)).excitation(1.0)
    for array in (excitation.initial, excitation.times, excitation.values):
        assert array.dtype == np.float64
        assert array.flags.c_contiguous
    assert excitation.initial.shape == (2,)
    assert excitation.values.shape == (excitation.times.size, 2)


@pytest.mark.parametrize(
    ("entries", "n"),
    [
        ({"stepping": "full"}, 1),
        ({"stepping": "full", "microsteps": 1}, 1),
        ({"stepping": "half"}, 2),
        ({"stepping": "half", "microsteps": 2}, 2),
        ({"stepping": "micro", "microsteps": 16}, 16),
    ],
)
def test_steps_per_full_step(tmp_path, entries, n):
    assert from_table({**entries, "rate": 46}, tmp_path).steps_per_full_step == n


def test_a_full_table(tmp_path):
    table = {
        "stepping": "micro",
        "microsteps": 16,
        "rate_profile": [[0, 0], [60.0, 120.0]],
        "start_angle_deg": -30,
        "waveform": "square",
        "start": "equilibrium",
    }
    assert from_table(table, tmp_path) == Command(
        stepping="micro",
        microsteps=16,
        rate=RateProfile(times_s=(0.0, 60.0), rates=(0.0, 120.0)),
        start_angle_deg=-30.0,
        waveform="square",
        start="equilibrium",
    )


def test_defaults(tmp_path):
    """Truth: the campaign contract: 0 deg, cosine, commanded."""
    command = from_table({"stepping": "full", "rate": 46}, tmp_path)
    assert (command.start_angle_deg, command.waveform, command.start) == (0.0, "cosine", "commanded")
    assert command.rate == RateProfile.constant(46.0)


def test_start_angle():
    """Truth: 90 deg are a quarter turn."""
    command = Command(stepping="full", microsteps=1, rate=RateProfile.constant(1.0), start_angle_deg=90.0)
    assert command.start_angle_rad == pytest.approx(math.pi / 2, rel=1e-15)


@pytest.mark.parametrize(
    ("rate", "most"), [(0.0, 0), (0.5, 1), (46.0, 1), (100.0, 1), (101.0, 2), (199.0, 2), (250.0, 3)]
)
def test_edges_per_sample(rate, most):
    """Truth: an interval of 10 ms holds at most ceil(0.01 rate) edges that are 1/rate apart."""
    command = Command(stepping="full", microsteps=1, rate=RateProfile.constant(rate))
    assert command.max_edges_per_sample(0.01, 10.0) == most


def test_steps_wait_for_the_clock(tmp_path):
    """Truth: k/3 s to the next tenth of a second; the step at 1 s is on its tick."""
    table = {"stepping": "full", "rate": 3.0, "clock_tick_s": 0.1}
    times = Command.from_table(table, "here", tmp_path).excitation(1.45).times
    assert times == pytest.approx([0.4, 0.7, 1.0, 1.4], abs=1e-12)


def test_of_steps_due_at_one_tick_the_last_holds(tmp_path):
    """Truth: at 10 steps/s and a tick of 0.25 s the indices 2, 5, 7 and 10, and one edge in any quarter of a second."""
    command = Command.from_table({"stepping": "full", "rate": 10.0, "clock_tick_s": 0.25}, "here", tmp_path)
    plain = Command.from_table({"stepping": "full", "rate": 10.0}, "here", tmp_path).excitation(1.0)
    excitation = command.excitation(1.0)
    assert excitation.times == pytest.approx([0.25, 0.5, 0.75, 1.0], abs=1e-12)
    np.testing.assert_array_equal(excitation.values, plain.values[[1, 4, 6, 9]])
    assert command.max_edges_per_sample(0.2, 1.0) == 1


def test_a_tick_longer_than_the_record_holds_the_start(tmp_path):
    command = Command.from_table({"stepping": "full", "rate": 10.0, "clock_tick_s": 2.0}, "here", tmp_path)
    assert command.excitation(1.0).times.size == 0


def test_a_tick_that_cannot_be_is_refused(tmp_path):
    with pytest.raises(InputFileError) as caught:
        Command.from_table({"stepping": "full", "rate": 10.0, "clock_tick_s": -1e-3}, "here", tmp_path)
    assert str(caught.value) == "here.clock_tick_s: found -0.001; write a period in s, or 0 for none"


@pytest.mark.parametrize("duration", [-1.0, math.nan, math.inf])
def test_a_duration_that_cannot_be(duration):
    with pytest.raises(UsageError, match=r"^duration_s: found "):
        Command(stepping="full", microsteps=1, rate=RateProfile.constant(1.0)).excitation(duration)


def test_a_table_in_a_file(tmp_path):
    (tmp_path / "rate.csv").write_text("time_s,rate\n0,0\n2,10\n")
    command = from_table({"stepping": "full", "rate_table": "rate.csv"}, tmp_path)
    assert command.rate == RateProfile(times_s=(0.0, 2.0), rates=(0.0, 10.0))


FULL = {"stepping": "full"}
MICRO = {"stepping": "micro", "rate": 46.0}
GOOD = {"stepping": "full", "rate": 46.0}

WRONG = {
    "unknown key": ({**GOOD, "microstep": 2}, '.microstep: unknown key; did you mean "microsteps"?'),
    "far from any key": (
        {**GOOD, "xyz": 2},
        ".xyz: unknown key; the keys of a command are stepping, microsteps, rate, rate_profile, rate_table, "
        "step_times, start_angle_deg, waveform, table, start, clock_tick_s",
    ),
    "no stepping": ({"rate": 46.0}, '.stepping: missing; write one of "full", "half", "micro"'),
    "near stepping": ({**GOOD, "stepping": "mikro"}, '.stepping: found "mikro"; did you mean "micro"?'),
    "stepping of another type": (
        {**GOOD, "stepping": 16},
        '.stepping: found 16; write one of "full", "half", "micro"',
    ),
    "no rate": (FULL, ".rate: missing; write rate = 46.0 (full steps/s), or rate_profile, rate_table or step_times"),
    "two rates": (
        {**GOOD, "rate_profile": [[0, 1]]},
        ".rate_profile: found beside rate; keep one of rate, rate_profile, rate_table, step_times",
    ),
    "two other rates": (
        {**FULL, "rate_table": "rate.csv", "rate_profile": [[0, 1]]},
        ".rate_table: found beside rate_profile; keep one of rate, rate_profile, rate_table, step_times",
    ),
    "rate as text": ({**FULL, "rate": "46"}, '.rate: found "46"; write a finite number'),
    "boolean rate": ({**FULL, "rate": True}, ".rate: found True; write a finite number"),
    "infinite rate": ({**FULL, "rate": math.inf}, ".rate: found inf; write a finite number"),
    "rate beyond floats": (
        {**FULL, "rate": 10**400},
        f".rate: found 1{'0' * 56}...; write a finite number",
    ),
    "micro without microsteps": (MICRO, ".microsteps: missing; micro stepping needs it, as microsteps = 16"),
    "no microsteps": ({**MICRO, "microsteps": 0}, ".microsteps: found 0; write an integer from 1 to 65536"),
    "broken microsteps": (
        {**MICRO, "microsteps": 16.0},
        ".microsteps: found 16.0; write an integer from 1 to 65536",
    ),
    "boolean microsteps": (
        {**MICRO, "microsteps": True},
        ".microsteps: found True; write an integer from 1 to 65536",
    ),
    "microsteps in full stepping": (
        {**GOOD, "microsteps": 16},
        '.microsteps: found 16; full stepping has 1: leave it out, or write stepping = "micro"',
    ),
    "microsteps in half stepping": (
        {**GOOD, "stepping": "half", "microsteps": 1},
        '.microsteps: found 1; half stepping has 2: leave it out, or write stepping = "micro"',
    ),
    "angle as text": (
        {**GOOD, "start_angle_deg": "45"},
        '.start_angle_deg: found "45"; write a finite number',
    ),
    "angle no number": (
        {**GOOD, "start_angle_deg": math.nan},
        ".start_angle_deg: found nan; write a finite number",
    ),
    "waveform": ({**GOOD, "waveform": "cosin"}, '.waveform: found "cosin"; did you mean "cosine"?'),
    "waveform of another type": (
        {**GOOD, "waveform": ["cosine"]},
        '.waveform: found [\'cosine\']; write one of "cosine", "square"',
    ),
    "start": ({**GOOD, "start": "rest"}, '.start: found "rest"; write one of "commanded", "equilibrium", "estimated"'),
    "profile of another type": (
        {**FULL, "rate_profile": 46.0},
        ".rate_profile: found 46.0; write [[time in s, full steps/s], ...]",
    ),
    "empty profile": (
        {**FULL, "rate_profile": []},
        ".rate_profile: found []; write [[time in s, full steps/s], ...]",
    ),
    "profile without rates": (
        {**FULL, "rate_profile": [[0.0, 1.0], [2.0]]},
        ".rate_profile[1]: found [2.0]; write [time in s, full steps/s]",
    ),
    "flat profile": (
        {**FULL, "rate_profile": [0.0, 60.0]},
        ".rate_profile[0]: found 0.0; write [time in s, full steps/s]",
    ),
    "boolean in a profile": (
        {**FULL, "rate_profile": [[0.0, 1.0], [1.0, True]]},
        ".rate_profile[1]: found [1.0, True]; write two finite numbers",
    ),
    "profile not finite": (
        {**FULL, "rate_profile": [[0.0, math.inf]]},
        ".rate_profile[0]: found [0.0, inf]; write two finite numbers",
    ),
    "profile not ascending": (
        {**FULL, "rate_profile": [[0.0, 1.0], [2.0, 1.0], [1.5, 1.0]]},
        ".rate_profile[2]: time 1.5 s comes after 2.0 s; put the times in ascending order",
    ),
    "three at a time": (
        {**FULL, "rate_profile": [[1.0, 1.0], [1.0, 2.0], [1.0, 3.0]]},
        ".rate_profile[2]: third breakpoint at 1.0 s; a jump has two, the rate before and the rate after",
    ),
    "table name of another type": (
        {**FULL, "rate_table": 3},
        '.rate_table: found 3; write the name of a file, as "rate.csv"',
    ),
    "no table": ("full", ': found "full"; write a table, as { stepping = "full", rate = 46.0 }'),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_table_says_where_what_and_the_remedy(name, tmp_path):
    table, message = WRONG[name]
    with pytest.raises(InputFileError, match=f"^{re.escape(WHERE + message)}$"):
        from_table(table, tmp_path)


def test_a_missing_table_file_is_named(tmp_path):
    expected = f"{WHERE}.rate_table: {tmp_path / 'rate.csv'}: cannot be read (No such file or directory); check"
    with pytest.raises(InputFileError, match=f"^{re.escape(expected)}"):
        from_table({**FULL, "rate_table": "rate.csv"}, tmp_path)


def test_a_command_made_in_python_is_checked_too():
    with pytest.raises(UsageError, match=r"^microsteps: found 16; half stepping has 2"):
        Command(stepping="half", microsteps=16, rate=RateProfile.constant(1.0))


@pytest.mark.parametrize("begun_s", [0.05, 1.0 / 46.0, 0.7, 1.3])
@pytest.mark.parametrize("points", [[(0.0, 46.0)], [(0.0, 0.0), (0.5, 60.0), (1.0, -60.0)]])
def test_a_command_followed_from_later_on_is_the_rest_of_it(begun_s, points):
    """Truth: the whole command, cut at that time; the angle there is that of the voltages held."""
    whole = Command(stepping="micro", microsteps=4, rate=RateProfile.through(points), start_angle_deg=30.0)
    later, edges = whole.begin_at(begun_s), whole.excitation(2.0)
    rest, found = edges.times > begun_s, later.excitation(2.0 - begun_s)
    np.testing.assert_allclose(found.times, edges.times[rest] - begun_s, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(found.values, edges.values[rest])
    held = edges.values[~rest][-1] if (~rest).any() else edges.initial
    np.testing.assert_array_equal(found.initial, held)
    angle = later.start_angle_rad
    np.testing.assert_allclose([-np.cos(angle), np.sin(angle)], held, rtol=0, atol=1e-12)
    assert later.start_rate == pytest.approx(np.interp(begun_s, *zip(*points, strict=True)))
    assert later.origin_s == begun_s
    assert whole.begin_at(-1.0).origin_s == 0.0
