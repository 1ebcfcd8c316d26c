"""Expressions in C. Truth: Python, for which arithmetic in C is the same text; else by hand from C's precedence."""

import ast

import numpy as np
import pytest

from mechid.kernel.c.expressions import Expressions
from mechid.kernel.c.types import DOUBLE, INT, INTEGERS, NUMBERS

TYPES = {"a": DOUBLE, "b": DOUBLE, "c": DOUBLE, "i": INT, "k": INT, "w": NUMBERS, "at": INTEGERS}


def in_c(text):
    return Expressions(TYPES, {}, {"N": 4}).text(ast.parse(text, mode="eval").body)


def drawn(rng, depth):
    """Return an expression drawn at random, every part of it in brackets."""
    if depth == 0:
        return str(rng.choice(["a", "b", "c", "2.5"]))
    left, right = drawn(rng, depth - 1), drawn(rng, depth - 1)
    return f"(-({left}))" if rng.random() < 0.15 else f"(({left}) {rng.choice(['+', '-', '*', '/'])} ({right}))"


@pytest.mark.parametrize("seed", range(20))
def test_brackets_stand_where_the_order_of_operations_needs_them(seed):
    """Truth: the value of the expression with all its brackets, to the last bit."""
    rng = np.random.default_rng(seed)
    text = drawn(rng, 4)
    values = dict(zip("abc", rng.uniform(1.0, 2.0, 3), strict=True))
    with np.errstate(all="ignore"):
        np.testing.assert_array_equal(eval(in_c(text), dict(values)), eval(text, dict(values)))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a < b < c", "a < b && b < c"),
        ("a < b and (b < c or not i == k)", "a < b && (b < c || !(i == k))"),
        ("a if i else b", "i ? a : b"),
        ("w[i + 1]", "w[i + 1]"),
        ("at.shape[0] - 1", "at_count - 1"),
        ("int(a + b)", "(int)(a + b)"),
        ("int(i)", "i"),
        ("a ** 2", "pow(a, 2)"),
        ("min(a, b, c)", "smaller(smaller(a, b), c)"),
        ("max(i, k)", "larger_int(i, k)"),
        ("math.sqrt(abs(a))", "square_root(magnitude(a))"),
        ("np.nan", "NAN"),
    ],
)
def test_what_c_writes_otherwise(text, expected):
    assert in_c(text) == expected
