"""Sines of multiples of an angle as the kernel writes them, against the sine itself."""

import math

import pytest
import sympy as sp

from mechid.kernel.expressions import Angles


@pytest.mark.parametrize("order", [2, 64, 65, 138, 1000])
def test_a_sine_of_any_multiple_follows_from_that_of_the_angle(order):
    """Truth: Python's sine of the multiple; orders above 64 were left out."""
    x = sp.Symbol("x")
    angles = Angles(parameters=frozenset())
    angles.collect([sp.sin(x), sp.sin(order * x)])
    expression = angles.replace(sp.sin(order * x))
    value = 0.7
    known = dict(zip(angles.pair(0), (math.sin(value), math.cos(value)), strict=True))
    for name, definition in angles.multiples([expression]):
        known[sp.Symbol(name)] = float(definition.xreplace(known))
    assert float(expression.xreplace(known)) == pytest.approx(math.sin(order * value), abs=1e-11)
