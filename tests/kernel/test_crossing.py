"""Where a margin first reaches zero, against functions whose zeros are known."""

import numpy as np
import pytest

from mechid.kernel.crossing import first_zero


@pytest.mark.parametrize(
    ("margin", "armed", "instant", "armed_after"),
    [
        (lambda t: 1.0 - t, True, None, True),  # only at 1, past the end
        (lambda t: 0.3 - t, True, 0.3, True),
        (lambda t: (t - 0.3) * (t - 0.31), True, 0.3, True),  # there and back between two looks
        (lambda t: (t - 0.3) ** 2 + 1e-4, True, None, True),  # a near miss
        (lambda t: np.cos(40.0 * t), True, np.pi / 80, True),  # the first of many
        (lambda t: t, False, None, True),  # grows from zero
        (lambda t: t * (0.6 - t), False, 0.6, True),  # grows and comes back
        (lambda t: -t, False, 0.0, False),  # falls at once
        (lambda t: 0.0 * t, False, None, False),  # stays at zero
    ],
)
def test_the_first_zero_is_found(margin, armed, instant, armed_after):
    """Truth: the zero of the formula."""
    found, now = first_zero(margin, 0.0, 0.9, armed)
    assert now is armed_after
    assert found is None if instant is None else found == pytest.approx(instant, rel=1e-12, abs=1e-15)
