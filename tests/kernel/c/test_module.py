"""The parts of a kernel's text. Truth: Python itself, which runs what was left as it ran the whole."""

import numpy as np
import pytest

from mechid.kernel.c.module import fold_zeros, module_of
from small_kernel import TEXT, ran

DRAWS = [([0.1, 3.0, 2.0, -1.0], 0.0), ([5.0, 0.6, 0.7, 0.8], 0.65), ([2.0, 2.0, 2.0, 2.0], -1.0)]


@pytest.fixture
def whole():
    return module_of(TEXT)


def test_constants_functions_and_comments_are_told_apart(whole):
    """Truth: the text."""
    assert whole.constants["N"] == 4
    assert whole.constants["SCALE"] == 0.5
    np.testing.assert_array_equal(whole.constants["ORDER"], [2, 0, 3, 1])
    assert list(whole.functions) == ["weighted", "ends", "never_called", "run"]
    assert whole.headings == {"weighted": ("Sums of what", "is weighted.")}
    assert list(whole.comments.values()) == ["by place"]


@pytest.mark.parametrize(("w", "low"), DRAWS)
def test_what_is_idle_is_gone_and_the_rest_gives_the_same(whole, w, low):
    """Truth: the whole text with the argument at 0."""
    left = fold_zeros(module_of(TEXT), ("sensitive",))
    assert list(left.functions) == ["weighted", "ends", "run"]
    assert [a.arg for a in left.functions["run"].args.args] == ["w", "out", "low"]
    assert [a.arg for a in left.functions["weighted"].args.args] == ["w"]
    count, out = ran(left, w, low)
    expected, written = ran(whole, w, low, 0)
    assert count == expected
    np.testing.assert_array_equal(out, written)
    assert ran(whole, w, low, 1)[1][0] == written[0] + 1000.0


def test_a_heading_stays_where_its_function_is(whole):
    assert fold_zeros(whole, ("sensitive",)).headings == {"weighted": ("Sums of what", "is weighted.")}
