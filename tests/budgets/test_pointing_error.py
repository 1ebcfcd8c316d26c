"""Parts of a pointing error under an index. Truth: mean squares in closed form, and integrals by quadrature."""

import numpy as np
import pytest
from scipy import integrate

from mechid.budgets.indices import Index
from mechid.budgets.pointing_error import (
    FlatRandom,
    Incoherent,
    Instants,
    PointingError,
    Sampled,
    Source,
    flat_share,
    phases,
)

APE = Index("APE")
INDICES = [APE, Index("MPE", 0.03), Index("RPE", 0.03)]
LINES = Source("wheel", 10.0, np.array([1, 3]), np.array([[1.0, 0.5j], [2.0j, 0.1]]))


@pytest.mark.parametrize("index", INDICES, ids=lambda index: index.kind)
def test_the_mean_square_of_a_waveform_is_what_the_weights_say(index):
    """Truth: Parseval; the instants are equidistributed over the phase and over the index's window."""
    seen = LINES.waveform(index, Instants(8192, 1, 0))
    np.testing.assert_allclose(np.mean(seen**2, axis=0), LINES.square(index), rtol=2e-3)


def test_bias_lines_and_noise_add_in_the_mean_square():
    """Truth: b^2 + A^2/2 + sigma^2 + the power of lines without phases; a bias is nothing under RPE."""
    parts = (Source("line", 10.0, np.array([1]), np.array([[2.0]])),)
    randoms = (FlatRandom(50.0, np.array([0.5])), Incoherent(np.array([7.0]), np.array([[0.3]])))
    error = PointingError(np.array([3.0]), parts, randoms)
    assert error.rms(APE)[0] == pytest.approx(np.sqrt(9.0 + 2.0 + 0.25 + 0.3))
    assert error.kept_bias(Index("RPE", 0.03))[0] == 0.0


@pytest.mark.parametrize(("bandwidth_hz", "window_s"), [(20.0, 0.03), (5.0, 2.0)])
def test_the_share_of_flat_noise_in_the_mean_over_a_window(bandwidth_hz, window_s):
    """Truth: the mean of sinc^2 over the band, by quadrature, to half a point of 2001 at its end."""
    kept, _ = integrate.quad(lambda f: np.sinc(f * window_s) ** 2, 0.0, bandwidth_hz, limit=200)
    assert flat_share(Index("MPE", window_s), bandwidth_hz) == pytest.approx(kept / bandwidth_hz, abs=3e-4)


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_phases_fill_their_torus_evenly(count):
    """Truth: Weyl's criterion; the mean of exp(2 pi i k.x) is zero for whole k other than zero."""
    x = np.array(phases(count, 8192))
    rng = np.random.default_rng(3)
    wave = rng.integers(-3, 4, size=(40, count))
    wave = wave[np.any(wave != 0, axis=1)]
    assert np.abs(np.exp(2j * np.pi * wave @ x).mean(axis=1)).max() < 1e-2


def test_sampled_values_are_each_taken_once_over_a_period():
    """Truth: as many instants as values, each at its own place; the mean square is NumPy's."""
    values = np.random.default_rng(4).normal(size=(1000, 2))
    part = Sampled(values)
    np.testing.assert_array_equal(part.waveform(APE, Instants(1000, 1, 0)), values)
    np.testing.assert_allclose(part.square(APE), np.mean(values**2, axis=0))
