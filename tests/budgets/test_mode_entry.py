"""The modes of a budget file. Truth: the rates as written, and a line with place and remedy for each fault."""

import tomllib

import numpy as np
import pytest

from mechid.budgets.example import BUDGET
from mechid.budgets.mode_entry import read_modes
from mechid.campaign.place import Place
from mechid.errors import InputFileError


def modes_of(text, folder):
    return read_modes(tomllib.loads(text), Place("budget.toml"), folder)


@pytest.mark.parametrize(
    ("rates", "expected", "refined"),
    [
        ("command.rate = 46.0", [46.0], False),
        ("rates = [46.0, 23.0, 46.0]", [23.0, 46.0], False),
        ("rate_range = { from = 10.0, to = 20.0, count = 3 }", [10.0, 15.0, 20.0], True),
    ],
)
def test_rates_are_given_in_one_of_three_ways(tmp_path, rates, expected, refined):
    """Truth: the numbers as written, sorted, each once; a range alone is refined at crossings."""
    text = f'[[mode]]\nname = "m"\ncommand.stepping = "full"\ncommand.start_angle_deg = 45.0\n{rates}\n'
    (mode,) = modes_of(text, tmp_path)
    np.testing.assert_array_equal(mode.rates, expected)
    assert mode.refined is refined
    assert mode.command.rate.rates[0] == expected[0]


def test_a_budget_without_modes_is_refused(tmp_path):
    with pytest.raises(InputFileError, match=r"budget[.]toml: no mode of operation; write one \[\[mode\]\] table"):
        modes_of("", tmp_path)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("count = 26", "count = 1", "mode[0].rate_range: found from 10 to 60 in 1 rates; from is below to"),
        ("microsteps = 16 }", "microsteps = 16, rate = 5.0 }", "mode[0]: found 2 of command.rate, rates, rate_range"),
        ("rate = 92.0", "rate = -92.0", "mode[1]: found -92; a steady rate is above 0"),
        ("rate = 92.0", "rate_profile = [[0, 1]]", "mode[1].duration_s: found 0; write a number above 0 in s"),
        ("rate = 92.0", "rat = 92.0", "mode[1]: found 0 of command.rate"),
        ("duty = 0.7 ", "# duty ", "mode[0].duty: missing; other modes have one"),
        ("duty = 0.7 ", "duty = 0.99 ", "duty: found 1.06 over all modes; together they are 1 at most"),
        ("duty = 0.05", "duty = 5.0", "mode[2].duty: found 5; write a share from 0 to 1"),
        ("rms_window_s = 0.5", "settle_s = 0.5", "mode[2].settle_s: is of a mode with steady rates"),
        ("rms_window_s = 0.5", "rms_window_s = 50", "mode[2].rms_window_s: found 50; the profile takes 10 s"),
    ],
)
def test_what_is_wrong_is_said(tmp_path, old, new, said):
    assert old in BUDGET
    with pytest.raises(InputFileError) as caught:
        modes_of(BUDGET.replace(old, new, 1), tmp_path)
    assert said in str(caught.value)
    assert str(caught.value).startswith("budget.toml: ")
