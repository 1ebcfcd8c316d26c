"""Commands by the instants of their steps. Truth: the instants themselves."""

import numpy as np
import pytest

import mechid
from mechid.command import Command
from mechid.errors import UsageError

RNG = np.random.default_rng(5)
IRREGULAR = np.cumsum(RNG.uniform(1e-3, 0.2, 300))


def command(times, **own):
    return Command.from_entries({"stepping": "full", "step_times": times, **own})


@pytest.mark.parametrize(("stepping", "n"), [("full", 1), ("half", 2), ("micro", 16)])
def test_each_step_is_at_its_instant(stepping, n):
    found = command(IRREGULAR.tolist(), stepping=stepping, microsteps=n)
    times, index = found._edges(IRREGULAR[-1] + 1.0)
    np.testing.assert_allclose(times, IRREGULAR, rtol=1e-14, atol=1e-14)
    np.testing.assert_array_equal(index, np.arange(1, 301))


def test_directions_turn_it_round():
    ways = np.where(RNG.uniform(size=300) < 0.5, 1, -1)
    times, index = command(np.column_stack([IRREGULAR, ways]).tolist())._edges(100.0)
    np.testing.assert_allclose(times, IRREGULAR, rtol=1e-14, atol=1e-14)
    np.testing.assert_array_equal(index, np.cumsum(ways))


def test_it_rests_before_the_first_step_and_after_the_last():
    found = command([1.0, 1.02, 1.04])
    rates = [found.rate.at(t) for t in (0.5, 0.97, 0.99, 1.03, 1.05, 9.0)]
    assert rates == pytest.approx([0.0, 0.0, 50.0, 50.0, 0.0, 0.0])


def test_equal_distances_are_a_constant_rate():
    """Truth: the same command by its rate."""
    by_rate = Command.from_entries({"stepping": "full", "rate": 46.0})
    by_times = command((np.arange(1, 47) / 46.0).tolist())
    one, other = by_rate.excitation(1.0), by_times.excitation(1.0)
    np.testing.assert_allclose(one.times, other.times, rtol=1e-14)
    np.testing.assert_array_equal(one.values, other.values)


def test_files_and_code_give_the_same(tmp_path):
    times = [0.1, 0.25, 0.3]
    (tmp_path / "steps.csv").write_text("time_s,direction\n0.1,1\n0.25,-1\n0.3,1\n")
    (tmp_path / "plain.csv").write_text("time_s\n0.1\n0.25\n0.3\n")
    turned = Command.from_entries({"stepping": "full", "step_times": "steps.csv"}, tmp_path)
    assert turned == mechid.make_command("full", step_times=[[0.1, 1], [0.25, -1], [0.3, 1]])
    assert Command.from_entries({"stepping": "full", "step_times": "plain.csv"}, tmp_path) == command(times)


WRONG = {
    "none": ([], "step_times: found none"),
    "zero": ([0.0, 0.1], "step_times[0]: found 0.0; write an instant in s above 0, where the command starts"),
    "order": ([0.1, 0.3, 0.2], "step_times[2]: found 0.2; write an instant in s above 0.3"),
    "twice": ([0.1, 0.1], "step_times[1]: found 0.1; write an instant in s above 0.1"),
    "text": ([0.1, "b"], 'step_times[1]: found "b"'),
    "direction": ([[0.1, 2]], "step_times[0]: direction 2; write 1 or -1"),
    "triple": ([[0.1, 1, 1]], "step_times[0]: found [0.1, 1, 1]; write an instant"),
    "scalar": (0.1, "step_times: found 0.1; write instants in s"),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_instants_are_refused_with_their_place(case):
    found, said = WRONG[case]
    with pytest.raises(UsageError) as refused:
        command(found)
    assert str(refused.value).startswith(said)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("t\n1\n", 'header: found "t"; write "time_s" or "time_s,direction"'),
        ("time_s\n0.1\nsoon\n", 'line 3: found "soon"; write an instant in s'),
        ("time_s,direction\n0.1,0\n", 'line 2: found "0.1,0"; write an instant in s and 1 or -1'),
        ("time_s\n0.2\n0.1\n", "step_times[1]: found 0.1"),
    ],
)
def test_wrong_files_are_refused_with_their_line(tmp_path, text, said):
    (tmp_path / "steps.csv").write_text(text)
    with pytest.raises(UsageError) as refused:
        Command.from_entries({"stepping": "full", "step_times": "steps.csv"}, tmp_path)
    assert str(tmp_path / "steps.csv") in str(refused.value)
    assert said in str(refused.value)


def test_a_rate_beside_them_is_refused():
    with pytest.raises(UsageError, match="step_times: found beside rate; keep one of"):
        command([0.1], rate=3.0)
