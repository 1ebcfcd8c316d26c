"""Time columns without a unit. Truth: the rate that the stamps were printed from."""

import numpy as np
import pytest

from mechid.errors import RecordError
from mechid.records import ChannelSpec, RecordSpec, read_record
from mechid.records.formats import open_table
from mechid.records.sampling import samplings
from mechid.records.spec import Conditioning, TimeStamps
from mechid.records.undeclared import read_bare

SAMPLES = np.arange(2000)
TORQUE = np.sin(SAMPLES / 7.0)
SPREADSHEET, DATENUM, JULIAN = 45987.41666667, 738000.41666667, 2460000.41666667


def days(start, rate_hz, digits=10):
    return [f"{start + k / rate_hz / 86400.0:.{digits}f}" for k in SAMPLES.tolist()]


def ticks(start, per_second, rate_hz):
    return [str(start + k * per_second // rate_hz) for k in SAMPLES.tolist()]


def seconds(start, rate_hz, digits=6):
    return [f"{start + k / rate_hz:.{digits}f}" for k in SAMPLES.tolist()]


def file(folder, time, header="Time,torque_Nm"):
    path = folder / "run.csv"
    rows = [f"{stamp},{torque:.9f}" for stamp, torque in zip(time, TORQUE, strict=True)]
    path.write_text("\n".join([header, *rows, ""]))
    return path


def read(path, **asked):
    return read_record(path, RecordSpec(name="run", path=path.name, **asked))


DATES = {
    **{f"days of a spreadsheet, {rate} Hz, {digits} digits": (days(SPREADSHEET, rate, digits), rate)
       for rate in (1, 10, 33, 100, 1000, 2048) for digits in (9, 10, 11)},
    "days of a spreadsheet, 10 kHz": (days(SPREADSHEET, 10000), 10000),
    **{f"datenum, {rate} Hz": (days(DATENUM, rate), rate) for rate in (10, 100, 1000)},
    **{f"Julian dates, {rate} Hz": (days(JULIAN, rate), rate) for rate in (10, 100, 1000)},
    **{f"1970, {name}, {rate} Hz": (ticks(17 * per_second * 10**8, per_second, rate), rate)
       for name, per_second in (("us", 10**6), ("ns", 10**9)) for rate in (10, 1000, 10000)},
    "1970, ms": (ticks(17 * 10**11, 1000, 100), 100),
    "FILETIME": (ticks(133450000000000000, 10**7, 10000), 10000),
    ".NET": (ticks(638300000000000000, 10**7, 1000), 1000),
}  # fmt: skip


@pytest.mark.parametrize("name", DATES)
def test_numbers_that_can_only_be_dates_are_read_and_it_is_said(name, tmp_path):
    time, rate_hz = DATES[name]
    path = file(tmp_path, time)
    for record in (read(path), *read_bare(path)):
        assert (record.time_start_s, record.sample_rate_hz) == (0.0, rate_hz)
        assert [treatment["step"] for treatment in record.treatments] == ["time_unit"]
        assert (
            "from its numbers, since it states no unit; record time 0 is its first number"
            in (record.treatments[0]["text"])
        )
    assert samplings(open_table(path, "run.csv"))[1].clock.rate_hz == rate_hz


SECONDS = {
    "since the recorder was switched on": (seconds(SPREADSHEET, 100), SPREADSHEET, 100.0),
    "the same, fast": (seconds(SPREADSHEET, 51200, 9), SPREADSHEET, 51200.0),
    "days since it was switched on": (seconds(738000.5, 1000), 738000.5, 1000.0),
    "since 1904, as LabVIEW's": (seconds(3.85e9, 1000), 3.85e9, 1000.0),
    "since 1970": (seconds(1.7e9, 1000), 1.7e9, 1000.0),
    "from 0, fast": (seconds(0.0, 1000000, 9), 0.0, 1e6),
}


@pytest.mark.parametrize("name", SECONDS)
def test_numbers_that_may_be_seconds_are_seconds(name, tmp_path):
    time, start_s, rate_hz = SECONDS[name]
    record = read(file(tmp_path, time))
    assert record.time_start_s == pytest.approx(start_s, abs=1e-6)
    assert record.sample_rate_hz == rate_hz
    assert record.treatments == ()


DOUBTFUL = {
    "days from 0": (days(0.0, 100, 13), r'faster than torque is recorded; state its unit, .*"time \[ms\]"'),
    "hours": ([f"{10.5 + k / 1000 / 3600:.12f}" for k in SAMPLES], "as seconds its numbers are 3.6e\\+06 Hz"),
    "seconds at 2 MHz": (seconds(0.0, 2000000, 9), "as seconds its numbers are 2e\\+06 Hz"),
    "days at a rate that nobody sets": (
        days(SPREADSHEET, 33.77, 11),
        r"are they days \(a spreadsheet's .*unit = \"d\"",
    ),
}


@pytest.mark.parametrize("name", DOUBTFUL)
def test_a_clock_too_fast_for_torque_is_asked_about(name, tmp_path):
    time, words = DOUBTFUL[name]
    path = file(tmp_path, time)
    for reader in (read, read_bare):
        with pytest.raises(RecordError, match=words):
            reader(path)


def test_a_header_that_calls_dates_seconds_is_refused(tmp_path):
    with pytest.raises(RecordError, match=r'column "Time \[s\]": says "s", but 45987.4166667 .* are days .*correct'):
        read(file(tmp_path, days(SPREADSHEET, 100), "Time [s],torque_Nm"))


@pytest.mark.parametrize(("unit", "scale"), [("d", 86400.0), ("h", 3600.0), ("min", 60.0)])
def test_a_stated_unit_holds_and_its_digits_leave_the_clock_regular(unit, scale, tmp_path):
    time = [f"{10.5 + k / 1000 / scale:.9f}" for k in SAMPLES]
    named = read(file(tmp_path, time, f"Time [{unit}],torque_Nm"))
    asked = read(file(tmp_path, time), time=ChannelSpec(quantity="time", column=0, unit=unit))
    for record in (named, asked):
        assert record.sample_rate_hz == pytest.approx(1000.0, rel=2e-9 * scale)
        assert record.time_start_s == pytest.approx(10.5 * scale, abs=1e-9 * scale)
        assert record.treatments == ()


def test_a_window_of_dates_counts_from_the_first_number(tmp_path):
    conditioning = Conditioning(window_s=(0.995, 5.005))
    record = read(file(tmp_path, days(SPREADSHEET, 100)), conditioning=conditioning)
    assert record.samples == 401
    assert record.time_start_s == pytest.approx(1.0, abs=1e-5)
    np.testing.assert_allclose(record.channels[0].data, TORQUE[100:501], atol=1e-9)


def test_missing_samples_at_the_ends_do_not_change_the_unit(tmp_path):
    path = file(tmp_path, days(SPREADSHEET, 100))
    lines = path.read_text().splitlines()
    lines[1] = lines[1].partition(",")[0] + ",nan"
    path.write_text("\n".join([*lines, ""]))
    record = read_bare(path)[0]
    assert record.sample_rate_hz == 100.0
    assert record.samples == SAMPLES.size - 1


def test_late_dates_are_put_on_the_nearest_clock(tmp_path):
    late = np.random.default_rng(1).uniform(0.0, 2e-3, SAMPLES.size)
    time = [f"{SPREADSHEET + (k / 100 + dt) / 86400:.11f}" for k, dt in zip(SAMPLES, late, strict=True)]
    record = read(file(tmp_path, time), conditioning=Conditioning(time_stamps=TimeStamps.REGULAR))
    assert record.sample_rate_hz == pytest.approx(100.0, rel=1e-5)
    assert [treatment["step"] for treatment in record.treatments] == ["time_unit", "time_stamps"]


def test_dates_of_too_few_digits_agree_with_a_given_rate(tmp_path):
    channels = (ChannelSpec(quantity="torque", column=1),)
    time = ChannelSpec(quantity="time", column=0, unit="d")
    record = read(file(tmp_path, days(SPREADSHEET, 100, 6)), sample_rate_hz=100.0, channels=channels, time=time)
    assert record.sample_rate_hz == 100.0
