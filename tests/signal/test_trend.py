"""Offset and drift against NumPy's least squares over the whole series, and against their closed forms."""

import numpy as np
import pytest

from mechid.signal.series import BLOCK
from mechid.signal.trend import Line, fit_line


@pytest.mark.parametrize("samples", [2, 3, 1000, 2 * BLOCK + 17])
@pytest.mark.parametrize("terms", [1, 2])
def test_the_line_is_that_of_the_dense_least_squares(samples, terms):
    """Truth: numpy's lstsq on the columns 1 and k."""
    series = 5.0 + np.random.default_rng(samples).standard_normal(samples).cumsum()
    columns = np.vander(np.arange(samples, dtype=float), terms, increasing=True)
    fitted = columns @ np.linalg.lstsq(columns, series, rcond=None)[0]
    line = fit_line(series, terms)
    np.testing.assert_allclose(line.at(0, samples), fitted, rtol=0.0, atol=1e-9 * np.ptp(series))


def test_a_line_is_found_and_taken_away():
    """Truth: the series is a line."""
    k = np.arange(3 * BLOCK)
    series = 0.3 - 2e-6 * k
    line = fit_line(series, 2)
    assert (line.offset, line.slope) == pytest.approx((0.3, -2e-6), rel=1e-10)
    line.subtract_from(series)
    assert np.max(np.abs(series)) < 1e-12


@pytest.mark.parametrize(
    ("series", "terms", "line"),
    [
        ([1.0, 2.0, 4.0], 0, Line()),
        ([3.0], 2, Line(3.0)),
        ([], 2, Line()),
        ([1.0, 2.0, 3.0], 1, Line(2.0)),
    ],
)
def test_short_series_and_few_terms(series, terms, line):
    assert fit_line(np.array(series), terms) == line
