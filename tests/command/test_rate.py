"""Rate profiles and the tables they are read from. Truth: the numbers written, and a line for each fault."""

import re

import numpy as np
import pytest

from mechid.command import RateProfile, read_rate_table
from mechid.command.edges import step_edges
from mechid.errors import InputFileError, UsageError

GOOD_FILES = {
    "plain": "time_s,rate\n0,0\n60,120\n",
    "spaces and an empty line": "time_s, rate\n\n 0.0 , 0 \n6e1, 120.0\n\n",
    "byte order mark and carriage returns": "\ufefftime_s,rate_full_steps_per_s\r\n0,0\r\n60,120\r\n",
}


@pytest.mark.parametrize("name", GOOD_FILES)
def test_read_rate_table(name, tmp_path):
    path = tmp_path / "rate.csv"
    path.write_bytes(GOOD_FILES[name].encode())
    assert read_rate_table(path) == RateProfile(times_s=(0.0, 60.0), rates=(0.0, 120.0))


HEADER_REMEDY = (
    'write "time_s,rate", times in s and rates in full steps/s (the rate may also be called '
    '"rate_steps_per_s", "rate_full_steps_per_s")'
)

BAD_FILES = {
    "empty": (b"", 'the file is empty; write a header line "time_s,rate", then the rates'),
    "no rows": (b"time_s,rate\n", "no line after the header; write one time and rate or more"),
    "no header": (b"0,0\n60,120\n", f'header: found "0,0"; {HEADER_REMEDY}'),
    "another unit": (
        b"time_s,rate_deg_per_s\n0,0\n",
        f'header: found "time_s,rate_deg_per_s"; {HEADER_REMEDY}',
    ),
    "third column": (b"time_s,rate,x\n0,0,0\n", f'header: found "time_s,rate,x"; {HEADER_REMEDY}'),
    "text": (b"time_s,rate\n0,0\n\n1,fast\n", 'line 4: found "1,fast"; write a time and a rate'),
    "short line": (b"time_s,rate\n0,0\n1\n", 'line 3: found "1"; write a time and a rate'),
    "not finite": (b"time_s,rate\n0,nan\n", "line 2: found [0.0, nan]; write two finite numbers"),
    "not ascending": (
        b"time_s,rate\n1,0\n\n0.5,0\n",
        "line 4: time 0.5 s comes after 1.0 s; put the times in ascending order",
    ),
    "not text": (b"time_s,rate\n\xff\xfe,1\n", "is not plain text; save it as CSV in UTF-8"),
}


@pytest.mark.parametrize("name", BAD_FILES)
def test_a_bad_rate_table_says_where_what_and_the_remedy(name, tmp_path):
    content, message = BAD_FILES[name]
    path = tmp_path / "rate.csv"
    path.write_bytes(content)
    with pytest.raises(InputFileError, match=f"^{re.escape(f'{path}: {message}')}$"):
        read_rate_table(path)


def test_a_folder_is_no_rate_table(tmp_path):
    with pytest.raises(InputFileError, match=r"cannot be read \(.+\); check the path$"):
        read_rate_table(tmp_path)


@pytest.mark.parametrize(
    ("times", "rates", "message"),
    [
        ((), (), "rate profile: found 0 times and 0 rates; give one rate to each time, one pair or more"),
        ((0.0, 1.0), (1.0,), "rate profile: found 2 times and 1 rates; give one rate to each time"),
        ((0.0, float("nan")), (1.0, 1.0), "rate profile: [1]: found [nan, 1.0]; write two finite numbers"),
        ((0.0, -1.0), (1.0, 1.0), "rate profile: [1]: time -1.0 s comes after 0.0 s"),
    ],
)
def test_a_profile_that_cannot_be(times, rates, message):
    with pytest.raises(UsageError, match=f"^{re.escape(message)}"):
        RateProfile(times_s=times, rates=rates)


def test_a_jump_takes_effect_at_once():
    """Truth: 10 steps/s for 0.2 s, then 100 steps/s: steps 1, 2, then one every 10 ms."""
    times, _ = step_edges(RateProfile.through([(0.2, 10.0), (0.2, 100.0)]), 1, 0.23)
    np.testing.assert_allclose(times, [0.1, 0.2, 0.21, 0.22, 0.23], rtol=1e-15)
