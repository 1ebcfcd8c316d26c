"""Files of which nobody has said what they hold. Truth: the arrays that the test has written."""

import numpy as np
import pytest

from instrument_files import CURRENT, FORMATS, RATE, TIME, TORQUE
from mechid.errors import RecordError
from mechid.records.undeclared import Hints, read_bare


def written(path, time, *columns, header="time_s,torque_Nm", digits=9):
    rows = "".join(",".join(f"{value:.{digits}g}" for value in row) + "\n" for row in zip(time, *columns, strict=True))
    path.write_text(f"{header}\n{rows}")
    return path


@pytest.mark.parametrize("kind", FORMATS)
def test_every_format_gives_its_torque_and_the_column_without_a_unit(kind, tmp_path):
    one = FORMATS[kind]
    one.write(tmp_path / one.name)
    channels = [channel for record in read_bare(tmp_path / one.name) for channel in record.channels]
    torque = next(channel for channel in channels if channel.quantity == "torque")
    assert torque.unit == "N*m"
    assert torque.data == pytest.approx(TORQUE, abs=1e-6)
    current = next(channel for channel in channels if channel.column.endswith("iA") or channel.quantity == "current")
    assert current.data == pytest.approx(CURRENT, abs=1e-6)
    assert all(record.sample_rate_hz == pytest.approx(RATE) for record in read_bare(tmp_path / one.name))


def test_counts_and_unknown_units_keep_their_numbers(tmp_path):
    path = tmp_path / "a.npz"
    np.savez(path, time=TIME, ticks=np.arange(64) % 7, acceleration_g=TORQUE)
    (record,) = read_bare(path)
    assert {(c.quantity, c.unit) for c in record.channels} == {("ticks", "counts"), ("acceleration_g", "")}


def test_hints_say_what_the_file_does_not(tmp_path):
    path = tmp_path / "a.npy"
    np.save(path, 5.0 * TORQUE)
    (record,) = read_bare(path, Hints(sample_rate_hz=500.0, quantity="torque", unit="mNm"))
    assert (record.sample_rate_hz, record.channels[0].quantity) == (500.0, "torque")
    assert record.channels[0].data == pytest.approx(5e-3 * TORQUE)


def test_a_column_may_be_chosen(tmp_path):
    path = written(tmp_path / "a.csv", TIME, TORQUE, CURRENT, header="time_s,torque_Nm,iA_A")
    (record,) = read_bare(path, Hints(columns=("iA",)))
    assert [channel.quantity for channel in record.channels] == ["current"]
    with pytest.raises(RecordError, match="which column are --quantity and --unit of"):
        read_bare(path, Hints(unit="mNm"))


def test_missing_samples_are_bridged_and_missing_ends_cut(tmp_path):
    torque = TORQUE.copy()
    torque[[0, 20, 21, 63]] = np.nan
    (record,) = read_bare(written(tmp_path / "a.csv", TIME, torque))
    (channel,) = record.channels
    assert record.time_start_s == pytest.approx(TIME[1])
    assert record.samples == 62
    assert channel.bridged.tolist() == [19, 20]
    assert channel.data[18] == pytest.approx(TORQUE[19], abs=1e-6)


def test_jittered_and_lost_stamps_are_put_on_the_nearest_clock(tmp_path):
    kept = np.delete(np.arange(64), [30, 31, 40])
    stamps = TIME[kept] + 1e-4 * np.random.default_rng(1).uniform(-1.0, 1.0, kept.size)
    (record,) = read_bare(written(tmp_path / "a.csv", stamps, TORQUE[kept]))
    assert record.samples == 64
    assert record.channels[0].bridged.tolist() == [30, 31, 40]
    assert any("irregular time" in line for line in record.warnings)


def test_a_first_column_that_is_a_clock_is_taken_for_it(tmp_path):
    path = tmp_path / "a.csv"
    np.savetxt(path, np.column_stack((TIME, TORQUE)), delimiter=",")
    assert read_bare(path)[0].sample_rate_hz == pytest.approx(RATE)
    np.savetxt(path, np.column_stack((TORQUE, CURRENT)), delimiter=",")
    with pytest.raises(RecordError, match="no time column; give --sample-rate-hz"):
        read_bare(path)
    assert len(read_bare(path, Hints(sample_rate_hz=100.0))[0].channels) == 2


def test_a_dead_channel_beside_a_live_one_is_a_warning(tmp_path):
    path = written(tmp_path / "a.csv", TIME, TORQUE, 0.0 * TORQUE, header="time_s,torque_Nm,other_Nm")
    (record,) = read_bare(path)
    assert [channel.column for channel in record.channels] == ["torque_Nm"]
    assert any("the channel is dead" in line for line in record.warnings)


@pytest.mark.parametrize(
    ("rows", "says"),
    [
        ([], "no samples"),
        ([(0.0, 1.0), (0.1, 2.0)], "2 samples"),
        ([(0.1 * k, np.nan) for k in range(50)], "no finite number"),
        ([(0.1 * k, 3.0) for k in range(50)], "the channel is dead"),
        ([(-0.1 * k, float(k)) for k in range(50)], "the clock goes back"),
    ],
    ids=["empty", "two samples", "nan everywhere", "constant", "backwards"],
)
def test_what_is_no_record_says_so_in_one_line(rows, says, tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("time_s,torque_Nm\n" + "".join(f"{t},{y}\n" for t, y in rows))
    with pytest.raises(RecordError, match=says) as raised:
        read_bare(path)
    assert "\n" not in str(raised.value)
