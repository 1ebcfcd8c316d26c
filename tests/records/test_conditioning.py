"""Conditioning against closed forms: what is done is what was declared, and it is written down."""

import numpy as np
import pytest

from mechid.errors import RecordError
from mechid.records import ChannelSpec, Conditioning, RecordSpec, TimeStamps, read_record
from mechid.records.time_stamps import fit_regular_clock

RATE = 1000.0
SAMPLES = 4000
TIME = np.arange(SAMPLES) / RATE
TONE = 10.0
"""Hz: slow against the clock, so that interpolation is exact to 1e-6."""
CHANNELS = (ChannelSpec(quantity="torque", column="torque"), ChannelSpec(quantity="rotor_angle", column="angle"))


def tone(time):
    return np.sin(2.0 * np.pi * TONE * np.asarray(time)) + 0.5


def read(folder, how, *, time=TIME, torque=None, rate=None):
    torque = tone(time) if torque is None else torque
    np.savez(folder / "run.npz", time=time, torque=torque, angle=np.cos(np.asarray(time)))
    return read_record(
        folder / "run.npz",
        RecordSpec(name="run", path="run.npz", sample_rate_hz=rate, channels=CHANNELS, conditioning=how),
    )


def refused(folder, how, **asked):
    with pytest.raises(RecordError) as caught:
        read(folder, how, **asked)
    assert str(caught.value).startswith("run.npz: ")
    return str(caught.value)


def torque_of(record):
    return record.channel("torque").data


def times(record):
    return record.time_start_s + np.arange(record.samples) / record.sample_rate_hz


def steps(record):
    return [done["step"] for done in record.treatments]


def test_nothing_declared_is_nothing_done(tmp_path):
    record = read(tmp_path, Conditioning())
    np.testing.assert_array_equal(torque_of(record), tone(TIME))
    assert record.treatments == ()
    assert record.provenance["conditioning"] == []


def test_a_window_keeps_both_its_ends(tmp_path):
    record = read(tmp_path, Conditioning(window_s=(0.5, 1.25)))
    assert (record.time_start_s, record.samples) == (0.5, 751)
    np.testing.assert_array_equal(torque_of(record), tone(TIME)[500:1251])
    assert record.provenance["conditioning"] == [
        {"step": "window", "text": "0.5 s to 1.25 s of the record used", "window_s": [0.5, 1.25]}
    ]


def test_a_window_outside_is_refused(tmp_path):
    assert "samples" in refused(tmp_path, Conditioning(window_s=(50.0, 60.0)))


def test_decimation_keeps_channels_together_and_their_times(tmp_path):
    record = read(tmp_path, Conditioning(decimate=4))
    assert (record.sample_rate_hz, record.samples, record.time_start_s) == (250.0, 1000, 0.0)
    inner = slice(100, -100)
    np.testing.assert_allclose(torque_of(record)[inner], tone(times(record))[inner], atol=2e-5)
    np.testing.assert_allclose(record.channel("rotor_angle").data[inner], np.cos(times(record))[inner], atol=2e-5)
    (done,) = record.treatments
    assert (done["step"], done["factor"], done["rate_hz"]) == ("decimate", 4, 250.0)
    assert done["pass_hz"] == pytest.approx(0.95 * 125.0)


def test_a_record_too_short_to_decimate_is_refused(tmp_path):
    assert "too few to decimate by 40" in refused(tmp_path, Conditioning(decimate=40))


def test_increments_are_summed_up_and_told(tmp_path):
    """Truth: the tone, which the test takes apart into increments."""
    increments = np.diff(tone(TIME), prepend=0.0)
    record = read(tmp_path, Conditioning(cumulate=("torque",), window_s=(1.0, 2.0)), torque=increments)
    np.testing.assert_allclose(torque_of(record) - torque_of(record)[0], tone(TIME[1000:2001]) - tone(1.0), atol=1e-12)
    assert steps(record) == ["cumulate", "window"]
    np.testing.assert_array_equal(record.channel("rotor_angle").data, np.cos(TIME[1000:2001]))


def test_a_quiet_stretch_gives_the_offset(tmp_path):
    torque = np.where(TIME < 0.5, 0.0, np.sin(TIME)) + 0.25
    record = read(tmp_path, Conditioning(quiet_s={"torque": ((0.0, 0.499),)}), torque=torque)
    np.testing.assert_allclose(torque_of(record), torque - 0.25, atol=1e-12)
    assert record.treatments[0]["offset"] == pytest.approx(0.25, abs=1e-12)
    np.testing.assert_array_equal(record.channel("rotor_angle").data, np.cos(TIME))


@pytest.mark.parametrize(("factor", "left"), [(1, 1.0), (5, 0.2)])
def test_a_quiet_stretch_tells_the_noise_of_the_record(factor, left, tmp_path):
    """Truth: white noise, of which the low-pass of a decimation leaves its share of the band."""
    noise = 0.01 * np.random.default_rng(5).standard_normal(TIME.size)
    how = Conditioning(quiet_s={"torque": ((0.0, 1.9),)}, window_s=(2.0, 3.9), decimate=factor)
    record = read(tmp_path, how, torque=noise + np.where(TIME < 2.0, 0.3, np.sin(40.0 * TIME)))
    assert record.quiet_rms("torque") == pytest.approx(0.01 * np.sqrt(left), rel=0.1)
    assert record.quiet_rms("rotor_angle") is None


def test_two_quiet_stretches_give_offset_and_drift(tmp_path):
    moving = np.where((TIME > 0.5) & (TIME < 3.5), np.sin(TIME), 0.0)
    how = Conditioning(quiet_s={"torque": ((0.0, 0.5), (3.5, 3.999))})
    record = read(tmp_path, how, torque=moving + 0.25 - 0.03 * TIME)
    np.testing.assert_allclose(torque_of(record), moving, atol=1e-12)
    assert record.treatments[0]["drift"] == pytest.approx(-0.03, abs=1e-12)


def test_a_quiet_stretch_may_lie_outside_the_window(tmp_path):
    how = Conditioning(quiet_s={"torque": ((0.0, 0.2),)}, window_s=(1.0, 2.0))
    record = read(tmp_path, how, torque=np.where(TIME < 0.5, 0.125, 1.0 + TIME))
    np.testing.assert_allclose(torque_of(record), 1.0 + TIME[1000:2001] - 0.125, atol=1e-12)
    assert steps(record) == ["quiet", "window"]


def with_gap(first, last):
    torque = 2.0 * TIME
    torque[first:last] = np.nan
    return torque


def test_a_gap_is_bridged_by_a_straight_line_and_told(tmp_path):
    record = read(tmp_path, Conditioning(max_gap_s=0.010), torque=with_gap(700, 710))
    np.testing.assert_allclose(torque_of(record), 2.0 * TIME, atol=1e-12)
    (done,) = record.treatments
    assert (done["step"], done["samples"], done["gaps"]) == ("gaps", 10, 1)
    assert done["longest_s"] == pytest.approx(0.010)
    assert done["first_at_s"] == [0.7]
    np.testing.assert_array_equal(record.channel("torque").bridged, np.arange(700, 710))
    assert record.channel("rotor_angle").bridged.size == 0


def test_bridged_samples_keep_their_places_in_a_window(tmp_path):
    how = Conditioning(max_gap_s=0.010, quiet_s={"torque": ((0.1, 0.2),)}, window_s=(0.705, 1.0))
    record = read(tmp_path, how, torque=with_gap(700, 706))
    np.testing.assert_array_equal(record.channel("torque").bridged, [0])


def test_decimated_samples_in_which_bridged_ones_have_a_part_are_none_either(tmp_path):
    """Truth: two records that differ within the gap alone differ nowhere else by more than that share of it."""
    how = Conditioning(max_gap_s=0.020, decimate=4)
    missing = read(tmp_path, how, torque=with_gap(2000, 2020)).channel("torque")
    other = 2.0 * TIME
    other[2000:2020] += 1.0
    moved = np.abs(read(tmp_path, Conditioning(decimate=4), torque=other).channel("torque").data - missing.data)
    kept = np.ones(moved.size, dtype=bool)
    kept[missing.bridged] = False
    assert set(range(500, 505)) <= set(missing.bridged.tolist())
    assert 5 <= missing.bridged.size < 60
    assert moved[kept].max() < 0.03 < moved[500:505].min()


@pytest.mark.parametrize(
    ("how", "first", "says"),
    [
        (Conditioning(max_gap_s=0.005), 700, "10 samples missing from 0.7 s on, 0.01 s, longer than max_gap_s = 0.005"),
        (Conditioning(max_gap_s=1.0), 0, "begins or ends with missing samples"),
        (Conditioning(max_gap_s=1.0), SAMPLES - 10, "begins or ends with missing samples"),
        (Conditioning(), 700, 'sample 700: column "torque": nan is not a finite number'),
    ],
)
def test_a_gap_that_is_not_allowed_is_refused(tmp_path, how, first, says):
    assert says in refused(tmp_path, how, torque=with_gap(first, first + 10))


def test_a_gap_outside_the_window_does_not_matter(tmp_path):
    record = read(tmp_path, Conditioning(window_s=(1.0, 2.0)), torque=with_gap(700, 710))
    assert steps(record) == ["window"]


def test_samples_at_the_instruments_limit_are_bridged_as_missing(tmp_path):
    torque = np.clip(tone(TIME), -0.4, 1.4)
    how = Conditioning(limits={"torque": (-0.4, 1.4)}, max_gap_s=0.05)
    record = read(tmp_path, how, torque=torque)
    beyond = (torque <= -0.4) | (torque >= 1.4)
    np.testing.assert_array_equal(torque_of(record)[~beyond], torque[~beyond])
    assert np.abs(torque_of(record) - 0.5).max() < 0.9
    assert record.treatments[0]["samples"] == int(beyond.sum())
    assert steps(record) == ["limits", "gaps"]


def jittered(share):
    return TIME + share / RATE * np.random.default_rng(3).uniform(-1.0, 1.0, SAMPLES)


def test_late_stamps_of_regular_samples_are_replaced(tmp_path):
    """Truth: the clock the stamps were jittered from; least squares find it to jitter / sqrt(samples)."""
    time = jittered(0.3)
    assert "irregular time" in refused(tmp_path, Conditioning(), time=time, torque=tone(TIME))
    record = read(tmp_path, Conditioning(time_stamps=TimeStamps.REGULAR), time=time, torque=tone(TIME))
    np.testing.assert_array_equal(torque_of(record), tone(TIME))
    assert record.sample_rate_hz == pytest.approx(RATE, rel=4.0 * 0.3 * 2.0 / SAMPLES**1.5)
    assert record.time_start_s == pytest.approx(0.0, abs=4.0 * 0.3 / RATE / np.sqrt(3.0) * 2.0 / np.sqrt(SAMPLES))
    (done,) = record.treatments
    assert done["jitter_rms_s"] == pytest.approx(0.3 / RATE / np.sqrt(3.0), rel=0.05)
    assert done["lost_samples"] == 0


def test_lost_samples_behind_jitter_are_found_and_bridged(tmp_path):
    time = jittered(0.2)
    kept = np.delete(np.arange(SAMPLES), [100, 2000, 2001, 2002, 3000])
    how = Conditioning(time_stamps=TimeStamps.REGULAR, max_gap_s=0.005)
    record = read(tmp_path, how, time=time[kept], torque=2.0 * TIME[kept])
    np.testing.assert_allclose(torque_of(record), 2.0 * TIME, atol=1e-12)
    assert record.treatments[0]["lost_samples"] == 5
    assert record.treatments[1]["first_at_s"] == pytest.approx([0.1, 2.0, 3.0], abs=1e-4)
    strict = Conditioning(time_stamps=TimeStamps.REGULAR)
    assert "3 samples missing from" in refused(tmp_path, strict, time=time[kept], torque=2.0 * TIME[kept])


def test_stamps_too_far_off_for_any_regular_clock_are_refused(tmp_path):
    how = Conditioning(time_stamps=TimeStamps.REGULAR)
    assert "too far to place its sample" in refused(tmp_path, how, time=TIME + 2e-4 * np.sin(3.0 * TIME) * 5.0)


def test_irregular_samples_are_interpolated(tmp_path):
    """Truth: the tone itself at the new instants; cubic splines err by 5/384 (omega h)^4 at most."""
    time = jittered(0.3)
    record = read(tmp_path, Conditioning(time_stamps=TimeStamps.RESAMPLE), time=time, rate=RATE)
    error = 5.0 / 384.0 * (2.0 * np.pi * TONE * 1.6 / RATE) ** 4
    np.testing.assert_allclose(torque_of(record)[5:-5], tone(times(record))[5:-5], atol=2.0 * error)
    assert record.time_start_s == time[0]
    assert record.treatments[0]["taken"] == "resample"


def test_a_hole_between_irregular_samples_is_a_gap(tmp_path):
    time = np.delete(jittered(0.2), np.arange(1000, 1020))
    how = Conditioning(time_stamps=TimeStamps.RESAMPLE)
    assert "max_gap_s = ... allows to bridge them" in refused(tmp_path, how, time=time, rate=RATE)
    bridged = Conditioning(time_stamps=TimeStamps.RESAMPLE, max_gap_s=0.025)
    assert steps(read(tmp_path, bridged, time=time, rate=RATE)) == ["time_stamps", "gaps", "gaps"]


@pytest.mark.parametrize("seed", range(20))
def test_a_slow_jittered_clock_with_losses_is_found(seed):
    """Truth: places drawn at random, one in twenty lost, stamped up to 0.3 intervals off."""
    rng = np.random.default_rng(seed)
    places = np.flatnonzero(rng.random(3000) > 0.05)
    rate = 10.0 ** rng.uniform(0.0, 4.0)
    time = 5.0 + (places + rng.uniform(-0.3, 0.3, places.size)) / rate
    found = fit_regular_clock(None, time, None)  # no table: an error would be a failure
    np.testing.assert_array_equal(found.places(slice(None)), places - places[0])
    assert found.clock.rate_hz == pytest.approx(rate, rel=1e-4)


@pytest.mark.parametrize("stamps", list(TimeStamps))
def test_a_clock_that_goes_back_is_always_refused(tmp_path, stamps):
    time = TIME.copy()
    time[50] = 0.02
    assert "the clock goes back" in refused(tmp_path, Conditioning(time_stamps=stamps), time=time)


def test_all_steps_are_done_in_their_order_and_told(tmp_path):
    torque = tone(TIME) + 0.1
    torque[1500:1503] = 9.0
    how = Conditioning(
        time_stamps=TimeStamps.REGULAR,
        limits={"torque": (-8.0, 8.0)},
        max_gap_s=0.01,
        quiet_s={"torque": ((0.0, 0.999),)},
        window_s=(1.0, 3.5),
        decimate=5,
    )
    record = read(tmp_path, how, time=jittered(0.1), torque=torque)
    assert steps(record) == ["limits", "time_stamps", "gaps", "quiet", "window", "decimate"]
    assert all(done["text"] for done in record.treatments)
    assert record.sample_rate_hz == pytest.approx(200.0, rel=1e-6)
    mean = float(np.mean(torque[:1000]))
    inner = slice(80, 95)
    np.testing.assert_allclose(torque_of(record)[inner], (tone(times(record)) + 0.1 - mean)[inner], atol=2e-3)


@pytest.mark.parametrize("samples", [2, 3])
def test_too_few_samples_for_a_spline_are_refused(tmp_path, samples):
    """Truth: a cubic through fewer than four points is not one."""
    how = Conditioning(time_stamps=TimeStamps.RESAMPLE)
    line = refused(tmp_path, how, time=jittered(0.3)[:samples], rate=RATE)
    assert f"{samples} samples; a cubic spline needs 4" in line
    assert read(tmp_path, how, time=jittered(0.3)[:20], rate=RATE).treatments[0]["taken"] == "resample"
