"""The record itself. Truth: counts by hand, NumPy's reader, and campaigns of the independent simulator."""

import tracemalloc

import numpy as np
import pytest

from mechid.errors import RecordError
from mechid.records import Channel, Record, RecordSpec, Role, read_record


def channel(quantity="torque", samples=100, role=Role.OUTPUT):
    return Channel(quantity=quantity, unit="N*m", data=np.zeros(samples), role=role, column=quantity)


def record(tmp_path, *channels, rate=50.0):
    return Record(
        name="run",
        path=tmp_path / "run.csv",
        digest="",
        time_start_s=1.0,
        sample_rate_hz=rate,
        channels=channels or (channel(),),
    )


def test_a_hundred_samples_of_50_hz_last_99_intervals(tmp_path):
    one = record(tmp_path)
    assert (one.samples, one.sample_interval_s) == (100, 0.02)
    assert one.duration_s == pytest.approx(1.98)


@pytest.mark.parametrize("size", [1, 7, 50, 100, 1000])
def test_blocks_cover_the_record_once(tmp_path, size):
    covered = [k for start, stop in record(tmp_path).blocks(size) for k in range(start, stop)]
    assert covered == list(range(100))
    assert all(0 < stop - start <= size for start, stop in record(tmp_path).blocks(size))


def test_channels_are_found_by_quantity_and_role(tmp_path):
    torque, current = channel(), channel("current_phase_a", role=Role.INPUT)
    one = record(tmp_path, torque, current)
    assert one.channel("current_phase_a") is current
    assert (one.outputs, one.inputs) == ((torque,), (current,))


def test_a_channel_that_is_not_there_is_refused_with_the_nearest(tmp_path):
    with pytest.raises(RecordError, match=r'run: no channel "torq"; did you mean "torque"\?'):
        record(tmp_path).channel("torq")
    with pytest.raises(RecordError, match='run: no channel "velocity"; it has torque'):
        record(tmp_path).channel("velocity")


CAMPAIGN = {
    "full_res": 10001,
    "full_half": 10001,
    "full_slow": 15001,
    "micro_res": 10001,
    "micro_2res": 10001,
    "sweep": 200001,
}


@pytest.mark.parametrize("kind", ["exact", "noisy"])
@pytest.mark.parametrize("name", CAMPAIGN)
def test_a_campaign_of_the_independent_simulator_is_read(campaign_folder, kind, name):
    """Twin: NumPy's reader with its defaults."""
    path = campaign_folder / kind / f"{name}.csv"
    found = read_record(path, RecordSpec(name=name, path=path.name))
    expected = np.loadtxt(path, delimiter=",", skiprows=1)
    np.testing.assert_array_equal(found.channel("torque").data, expected[:, 1])
    assert (found.samples, found.sample_rate_hz, found.time_start_s) == (CAMPAIGN[name], 10000.0, 0.0)
    assert found.duration_s == pytest.approx(expected[-1, 0], rel=1e-12)
    assert found.warnings == ()


def test_reading_holds_less_than_twice_the_files_arrays(tmp_path):
    """Truth: the peak that Python and NumPy allocate, against two columns of float64."""
    samples = 100001
    torque = np.random.default_rng(0).normal(size=samples)
    path = tmp_path / "long.csv"
    with path.open("w") as file:
        file.write("time_s,torque_Nm\n")
        file.writelines(f"{k * 1e-4:.6f},{value:.9e}\n" for k, value in enumerate(torque.tolist()))
    tracemalloc.start()
    try:
        found = read_record(path, RecordSpec(name="long", path="long.csv"))
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert found.samples == samples
    assert peak < 2.0 * 16 * samples + 2e6
