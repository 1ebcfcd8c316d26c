"""Samples at jumps: what noise loses there, so that a model with jumps is not favoured by it."""

import numpy as np
import pytest

from mechid.identification.output_error.jump_samples import Colour, samples_at
from mechid.signal.autoregression import Autoregression
from mechid.simulation.switch_log import Jumps

SAMPLES, DRAWS = 500, 4000
COLOURS = {
    "white": Autoregression(np.ones(1), 1.0),
    "anti-alias filter": Autoregression(np.array([1.0, -1.2, 0.5]), 1.0),
    "drift": Autoregression(np.array([1.0, -0.98]), 1.0),
    "differences": Autoregression(np.array([1.0, 0.6]), 1.0),
}


def drawn_samples(rng):
    """Return the samples at jumps 8 samples apart, of any share and up to 8 noise levels."""
    at = np.arange(10, SAMPLES - 10, 8)
    jumps = Jumps(at, rng.uniform(size=at.size), np.zeros((at.size, 1)))
    return samples_at(jumps, rng.uniform(-8.0, 8.0, at.size), 0, SAMPLES)


@pytest.mark.parametrize("colour", COLOURS)
def test_the_energy_lost_is_what_noise_loses(colour):
    """Truth: the mean over draws of noise of that colour, whitened again, with and without the drawing."""
    rng, model = np.random.default_rng(7), COLOURS[colour]
    samples = drawn_samples(rng)
    zero = np.zeros((DRAWS, model.order))
    white = rng.standard_normal((DRAWS, SAMPLES))
    coloured, _ = model.colour_rows(white, zero)
    samples.draw(coloured)
    left, _ = model.whiten_rows(coloured, zero)
    lost = np.sum(white**2, axis=1) - np.sum(left**2, axis=1)
    expected = samples.energy_lost(Colour.of(None if colour == "white" else model), np.zeros(0, dtype=np.int64))
    assert abs(np.mean(lost)) > 10.0 * np.std(lost) / np.sqrt(DRAWS)
    assert expected == pytest.approx(np.mean(lost), abs=4.0 * np.std(lost) / np.sqrt(DRAWS))


def test_samples_that_do_not_count_lose_nothing():
    """Truth: without these samples there are no jumps."""
    samples = drawn_samples(np.random.default_rng(7))
    assert samples.energy_lost(Colour.of(None), samples.places) == 0.0
