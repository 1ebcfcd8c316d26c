"""Row numbers beside time and torque. Truth: the arrays written; a file's own record of time is never its row count."""

import numpy as np
import pandas as pd
import pytest

from mechid.errors import RecordError
from mechid.records.undeclared import read_bare
from records_read import read, refused

RATE = 1e4
TORQUE = np.random.default_rng(5).normal(0.0, 0.3, 400)
TIME = np.arange(TORQUE.size) / RATE


@pytest.fixture
def written(tmp_path):
    """Write columns below a header, row numbers from `first` in the first of them."""

    def write(header, *columns, first=0):
        path = tmp_path / "run.csv"
        rows = np.column_stack([np.arange(first, first + TORQUE.size), *columns])
        body = "".join(",".join(f"{value:.9g}" for value in row) + "\n" for row in rows)
        path.write_text(f"{header}\n{body}" if header else body)
        return path

    return write


@pytest.mark.parametrize(
    "header",
    [",t,M", '"","t","M"', "Unnamed: 0,time,torque", "index,t,M", "Sequence,t,M", "Zeile,Zeit,Drehmoment", "#,t,M"],
)
@pytest.mark.parametrize("first", [0, 1])
def test_time_and_torque_after_row_numbers_are_read(written, header, first):
    path = written(header, TIME, TORQUE, first=first)
    record = read(path)
    assert record.sample_rate_hz == RATE
    assert record.channels[0].quantity == "torque"
    np.testing.assert_allclose(record.channels[0].data[:], TORQUE, rtol=1e-8)
    (looked,) = read_bare(path)
    assert looked.sample_rate_hz == RATE
    assert len(looked.channels) == 1
    np.testing.assert_allclose(looked.channels[0].data[:], TORQUE, rtol=1e-8)


def test_the_index_of_a_data_frame_is_no_clock(tmp_path):
    """Truth: what pandas writes of its own accord."""
    path = tmp_path / "frame.csv"
    pd.DataFrame({"t": TIME, "M": TORQUE}).to_csv(path)
    np.testing.assert_allclose(read(path).channels[0].data[:], TORQUE, rtol=1e-12)


ASKED = [
    ",torque",
    "X,torque",
    "x,M",
    "Sequence,torque",
    "Zeile,M",
    "nummer,M",
    "Unnamed: 0,M",
    "lfd. Nr.,M",
    "a,b",
    "t,M",
    "",
]


@pytest.mark.parametrize("header", ASKED)
@pytest.mark.parametrize("first", [0, 1, 100])
def test_row_numbers_alone_are_asked_about(written, header, first):
    """Truth: no recorder of a mechanism samples once a second, and nothing says that it did."""
    path = written(header, TORQUE, first=first)
    assert "sample_rate_hz" in refused(path) or "unit" in refused(path)
    with pytest.raises(RecordError, match="sample-rate-hz"):
        read_bare(path)


def test_seconds_that_are_called_so_are_a_clock(written):
    assert read(written("t_s,M", TORQUE)).sample_rate_hz == 1.0


def test_a_rate_that_the_user_gives_settles_it(written):
    path = written(",torque", TORQUE)
    assert refused(path, sample_rate_hz=RATE).startswith(
        "run.csv: column 0: without a name beside others: a row number"
    )
