"""Truth: arrays. What is worked out from a file piece by piece is what NumPy, or the same function, has from memory."""

import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from little_memory import IN_MEMORY, little_memory  # noqa: F401
from mechid.errors import UsageError
from mechid.signal import effective_samples, ljung_box, noise_floor, peak_spectrum
from mechid.signal.autoregression import fit_autoregression
from mechid.signal.clipping import clipped_runs
from mechid.signal.decimation import affected_samples, decimate
from mechid.signal.following import assess_following, first_out_of_step
from mechid.signal.moments import extremes, mean, norm, root_mean_square, standard_deviation
from mechid.signal.quiet_stretches import quiet_stretches
from mechid.signal.resolution import resolution
from mechid.signal.spikes import isolated_spikes, outliers
from mechid.signal.stored_series import SampleBuffer, StoredSeries, as_writable, pieces_of, samples_at, write_at

RNG = np.random.default_rng(12)
N = 5000
NOISE = RNG.standard_normal(N)
COLOURED = np.convolve(NOISE, [1.0, 0.6, 0.2])[:N]
REJECTED = np.array([3, 699, 700, 701, 4000])


@pytest.fixture
def kept(little_memory):  # noqa: F811
    """Return a function that puts an array into a file, as long as memory is little."""

    def keep(values):
        found = as_writable(np.asarray(values, dtype=float))
        assert isinstance(found, StoredSeries)
        return found

    return keep


@pytest.mark.parametrize(
    "part",
    [slice(None), slice(10, 20), slice(-7, None), slice(4990, 6000), slice(30, 20), slice(5, 4999, 7), slice(0, 0)],
)
def test_slices_are_those_of_the_array(kept, part):
    np.testing.assert_array_equal(kept(NOISE)[part], NOISE[part])


def test_what_is_written_is_read_by_several_threads(kept):
    series = kept(NOISE)
    series[100:200] = 7.0
    write_at(series, REJECTED, np.arange(5.0))
    expected = NOISE.copy()
    expected[100:200] = 7.0
    expected[REJECTED] = np.arange(5.0)
    with ThreadPoolExecutor(4) as threads:
        parts = list(threads.map(lambda k: series[k : k + 50], range(0, N, 50)))
    np.testing.assert_array_equal(np.concatenate(parts), expected)
    np.testing.assert_array_equal(samples_at(series, REJECTED), expected[REJECTED])


def test_samples_that_come_piece_by_piece_are_in_a_file_from_so_many_on(kept):
    few, many = SampleBuffer(), SampleBuffer()
    few.append(NOISE[:IN_MEMORY])
    for start in range(0, N, 41):
        many.append(NOISE[start : start + 41])
    assert isinstance(few.series(), np.ndarray)
    assert isinstance(many.series(), StoredSeries)
    np.testing.assert_array_equal(many.series()[:], NOISE)


def test_nothing_stays_on_the_disk(kept, little_memory):  # noqa: F811
    series = kept(NOISE)
    assert not any(path.is_file() and path.stat().st_size for path in little_memory.rglob("*"))
    del series
    assert not [path for path in little_memory.rglob("*") if path.is_file()]


def test_it_goes_to_another_process_as_its_samples(kept):
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(kept(NOISE)))[:], NOISE)


def test_more_than_the_disk_holds_is_refused_in_a_line(kept):
    with pytest.raises(UsageError, match=r"cannot store the samples .*MECHID_CACHE"):
        StoredSeries(2**50)


def test_moments_in_memory_are_those_of_numpy_to_the_last_bit():
    y = RNG.standard_normal(200_001)
    assert (mean(y), standard_deviation(y)) == (float(y.mean()), float(y.std()))
    assert root_mean_square(y) == float(np.sqrt(np.mean(y**2)))
    assert (norm(y), extremes(y)) == (float(np.linalg.norm(y)), (float(y.min()), float(y.max())))
    assert standard_deviation(y, REJECTED) == float(np.std(np.delete(y, REJECTED)))
    assert [*pieces_of(y)] == [slice(0, y.size)]


def test_moments_of_a_file_are_those_of_numpy(kept):
    y = kept(NOISE)
    found = [mean(y), standard_deviation(y), root_mean_square(y), norm(y), standard_deviation(y, REJECTED)]
    spread = np.std(np.delete(NOISE, REJECTED))
    expected = [NOISE.mean(), NOISE.std(), np.sqrt(np.mean(NOISE**2)), np.linalg.norm(NOISE), spread]
    np.testing.assert_allclose(found, expected, rtol=1e-13)
    assert extremes(y) == (NOISE.min(), NOISE.max())


def test_clipped_runs_across_pieces_are_whole(kept):
    y = np.clip(np.sin(np.arange(N) / 160.0), -0.9, 0.9)
    expected = clipped_runs_by_hand(y, 0.9)
    assert len(expected) > 5
    assert clipped_runs(kept(y)) == expected


def clipped_runs_by_hand(y, limit):
    at, runs, start = np.abs(y) >= limit, [], None
    for k, here in enumerate([*at.tolist(), False]):
        if here and start is None:
            start = k
        elif not here and start is not None:
            runs += [(start, k)] if k - start >= 8 else []
            start = None
    return tuple(runs)


TWINS = {
    "noise floor": lambda y: noise_floor(y, 1e4),
    "effective samples": effective_samples,
    "whiteness": lambda y: ljung_box(y).statistic,
    "whiteness between gaps": lambda y: ljung_box(y, rejected=REJECTED).statistic,
    "colour": lambda y: fit_autoregression(y).coefficients,
    "colour between gaps": lambda y: fit_autoregression(y, rejected=REJECTED).coefficients,
    "spectrum": lambda y: peak_spectrum(y, 1e4, 50)[1],
    "decimated": lambda y: decimate(y, 5)[:],
    "outliers": lambda y: outliers(y, 8.0),
    "spikes": lambda y: isolated_spikes(y, 0.1),
    "followed": lambda y: assess_following(y, y, 1e4).worst,
    "out of step": lambda y: first_out_of_step(y, 1e4, 0.05) or -1,
    "quiet": lambda y: [(one.first, one.stop, one.rms) for one in quiet_stretches(y, 1e3)],
}
LOOSE = {"noise floor": 0.1}
"""Of a long series it looks at segments that lie evenly over it: its own error."""


@pytest.mark.parametrize("name", TWINS)
def test_of_a_file_it_is_as_of_an_array(name, kept, monkeypatch):
    """Twin: the same function of the array, in as much memory as there is."""
    y = COLOURED + 30.0 * (np.arange(N) % 997 == 0)
    y[2000:2300] *= 1e-3
    series = kept(y)
    found = TWINS[name](series)
    monkeypatch.undo()
    expected = TWINS[name](y)
    np.testing.assert_allclose(found, expected, rtol=LOOSE.get(name, 1e-9), atol=1e-12)


def test_levels_of_a_converter_are_found_piece_by_piece(kept):
    assert resolution(kept(np.round(np.sin(np.arange(float(N))), 2))) == 0.01
    assert resolution(kept(NOISE)) == 0.0


def test_samples_spoilt_by_missing_ones_are_the_same_by_blocks(kept, monkeypatch):
    missing = np.concatenate([np.arange(1300, 1340), np.arange(4990, 5000)])
    found = affected_samples(missing, N, 4)
    monkeypatch.undo()
    np.testing.assert_array_equal(found, affected_samples(missing, N, 4))
