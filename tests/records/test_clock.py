"""The clock. Truth: the rate that stamps were made from; everything else is refused at its row."""

import numpy as np
import pytest

from mechid.errors import RecordError
from mechid.records.clock import BLOCK, read_clock
from stamps import Stamps


def printed(rate, samples, digits, start=0.0):
    """Stamps of a regular clock as a file prints them."""
    return np.round(start + np.arange(samples) / rate, digits)


def read(time, rate_hz=None):
    return read_clock(Stamps(), np.asarray(time, dtype=float), rate_hz)


REGULAR = [  # rate, samples, printed digits, start
    (10000.0, 600001, 6, 0.0),
    (10000.0, 16, 4, 0.0),
    (10000.0, 5000, 4, 12.3456),
    (10000.0, 20000, 9, -0.5),
    (1000.0, 100, 3, 0.0),
    (51200.0, 100000, 9, 0.0),
    (1.0, 20, 0, 0.0),
]


@pytest.mark.parametrize(("rate", "samples", "digits", "start"), REGULAR)
def test_a_whole_rate_is_read_back_exactly(rate, samples, digits, start):
    clock = read(printed(rate, samples, digits, start))
    assert clock.rate_hz == rate
    assert clock.start_s == pytest.approx(start, abs=1e-12)


@pytest.mark.parametrize("rate", [312.5, 0.4, 2.5])
@pytest.mark.parametrize("samples", [16, 1000])
def test_a_rate_that_is_not_whole_stays(rate, samples):
    assert read(printed(rate, samples, 5)).rate_hz == pytest.approx(rate, rel=1e-12)


@pytest.mark.parametrize(("rate", "digits"), [(44100.0, 6), (12345.6, 6), (3000.0, 5)])
def test_stamps_rounded_to_their_digits_are_regular(rate, digits):
    """The rate is then known as well as one digit over the record tells."""
    samples = 2000
    expected = pytest.approx(rate, rel=10.0**-digits * rate / (samples - 1))
    assert read(printed(rate, samples, digits)).rate_hz == expected


def test_stamps_that_were_added_up_are_regular():
    assert read(np.cumsum(np.full(600001, 1e-4))).rate_hz == 10000.0


def test_a_clock_that_is_really_faster_keeps_its_rate():
    """Half a millionth in 60 s is a third of a sample; the stamps can tell."""
    assert read(np.arange(600001) / 10000.005).rate_hz == pytest.approx(10000.005, rel=1e-12)


def regular():
    return np.arange(200) / 1000.0


def changed(row, value):
    time = regular()
    time[row] = value
    return time


def with_a_gap(row):
    time = regular()
    time[row:] += 1e-3
    return time


BACK = "; is another column the time?"
REFUSED = {
    "back": (changed(50, 0.048), None, f"row 50: the clock goes back, from 0.049 s to 0.048 s{BACK}"),
    "back with a rate": (changed(50, 0.048), 1000.0, f"row 50: the clock goes back, from 0.049 s to 0.048 s{BACK}"),
    "restarted": (
        np.concatenate((regular(), regular())),
        None,
        f"row 200: the clock goes back, from 0.199 s to 0 s{BACK}",
    ),
    "repeated": (
        changed(50, 0.049),
        None,
        "row 50: the time stamp 0.049 s is repeated; if the stamps have too few digits, "
        "give sample_rate_hz and name the channels",
    ),
    "constant": (
        np.ones(16),
        None,
        "row 1: the time stamp 1 s is repeated; if the stamps have too few digits, "
        "give sample_rate_hz and name the channels",
    ),
    "shifted": (
        changed(50, 0.05002),
        None,
        "row 50: irregular time: 0.05002 s comes 0.00102 s after the stamp before it, mostly it is 0.001 s; "
        "declare time_stamps or window_s in its conditioning; if the stamps have too few digits, "
        "give sample_rate_hz and name the channels",
    ),
    "contradiction": (
        regular(),
        2000.0,
        "row 3: sample_rate_hz = 2000 contradicts the time column: 0.003 s where it gives 0.0015 s",
    ),
    "gap in spite of the rate": (
        with_a_gap(120),
        1000.0,
        "row 120: sample_rate_hz = 1000 contradicts the time column: 0.121 s where it gives 0.12 s",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_bad_clock_is_refused_at_its_row(name):
    time, rate, message = REFUSED[name]
    with pytest.raises(RecordError) as caught:
        read(time, rate)
    assert str(caught.value) == message


@pytest.mark.parametrize("row", [1, 60, 199])
def test_a_missing_sample_is_refused_where_it_is_missing(row):
    with pytest.raises(RecordError, match=f"row {row}: irregular time: .* comes 0.002 s after"):
        read(with_a_gap(row))


@pytest.mark.parametrize("row", [BLOCK - 1, BLOCK, BLOCK + 1, 2 * BLOCK])
@pytest.mark.parametrize("delay", [-2e-4, -1e-4, 1e-5])
def test_a_fault_is_found_where_two_blocks_meet(row, delay):
    time = np.arange(2 * BLOCK + 5) / 10000.0
    time[row] += delay
    with pytest.raises(RecordError, match=f"row {row}: "):
        read(time)


@pytest.mark.parametrize("digits", [3, 4])
def test_a_given_rate_is_believed_where_the_stamps_have_too_few_digits(digits):
    clock = read(printed(9000.0, 5000, digits, start=2.0), 9000.0)
    assert (clock.start_s, clock.rate_hz) == (2.0, 9000.0)
