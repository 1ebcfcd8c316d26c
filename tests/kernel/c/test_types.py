"""Types of a kernel's functions in C. Truth: the annotations and assignments of a small module, by hand."""

import ast

import pytest

from mechid.kernel.c.module import module_of
from mechid.kernel.c.types import DOUBLE, INT, NUMBERS, names_in, signatures, type_of
from small_kernel import TEXT


@pytest.fixture(scope="module")
def module():
    return module_of(TEXT)


def test_a_signature_has_types_and_what_is_written(module):
    """Truth: by hand; `run` writes into `out` and hands `w` on to functions that only read it."""
    known = signatures(module.functions)
    assert dict(known["run"].arguments) == {"w": NUMBERS, "out": NUMBERS, "low": DOUBLE, "sensitive": INT}
    assert known["run"].written == {"out"}
    assert known["run"].returns == (INT,)
    assert known["ends"].returns == (DOUBLE, DOUBLE)


def test_what_a_callee_writes_its_caller_writes_too():
    """Truth: by hand; and of which array the length is asked."""
    text = """
def inner(a: Numbers) -> None:
    a[0] = 1.0


def outer(b: Numbers, c: Integers) -> int:
    inner(b)
    return c.shape[0]
"""
    known = signatures(module_of(text).functions)
    assert known["outer"].written == {"b"}
    assert known["outer"].counted == {"c"}


def test_names_have_the_type_of_their_first_assignment(module):
    known = signatures(module.functions)
    names = names_in(module.functions["run"], known, module.constants)
    assert {name: names[name] for name in ("least", "largest", "above", "k")} == {
        "least": DOUBLE,
        "largest": DOUBLE,
        "above": INT,
        "k": INT,
    }


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("i + 1", INT),
        ("i + 1.0", DOUBLE),
        ("i / 2", DOUBLE),
        ("i ** 2", DOUBLE),
        ("-i", INT),
        ("x < 1.0", INT),
        ("i if x > 0.0 else x", DOUBLE),
        ("int(x)", INT),
        ("sqrt(x)", DOUBLE),
        ("max(i, 2)", INT),
        ("max(i, x)", DOUBLE),
        ("w[i]", DOUBLE),
        ("ORDER[i]", INT),
        ("np.nan", DOUBLE),
    ],
)
def test_the_type_of_an_expression(module, text, kind):
    """Truth: Python's own arithmetic on an int i and a float x."""
    expression = ast.parse(text, mode="eval").body
    assert type_of(expression, {"i": INT, "x": DOUBLE, "w": NUMBERS}, {}, module.constants) == kind
