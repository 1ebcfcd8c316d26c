"""A kernel's functions in C. Truth: Python, which runs the same text, and a compiler's every warning."""

import ctypes

import numpy as np
import pytest

from mechid.exports.c.compiler import compile_sources, find_compiler
from mechid.kernel.c.module import fold_zeros, module_of
from mechid.kernel.c.printer import WIDTH, Printer, wrap_line
from small_kernel import TEXT, ran

BEFORE = """
static double smaller(double a, double b) { return a < b ? a : b; }
static double larger(double a, double b) { return a > b ? a : b; }
"""
BEHIND = """
int called(const double *w, double *out, double low);
int called(const double *w, double *out, double low) { return run(w, out, low); }
"""


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler is installed")
def test_it_computes_what_python_computes(tmp_path):
    """Truth: the same text run by Python, on 50 draws, to the last bit."""
    module = fold_zeros(module_of(TEXT), ("sensitive",))
    printer = Printer(module)
    source = tmp_path / "small.c"
    source.write_text("\n".join([printer.constants(), BEFORE, printer.text(), BEHIND]), encoding="utf-8")
    flags = ["-shared", "-fPIC", "-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off"]
    called = ctypes.CDLL(str(compile_sources([source], tmp_path / "small.so", flags=flags))).called
    pointer = np.ctypeslib.ndpointer(dtype=np.float64, flags="C_CONTIGUOUS")
    called.argtypes, called.restype = [pointer, pointer, ctypes.c_double], ctypes.c_int
    rng = np.random.default_rng(1)
    for _ in range(50):
        w, low, out = rng.normal(1.0, 1.0, 4), float(rng.normal()), np.zeros(4)
        count, expected = ran(module, w, low)
        assert called(w, out, low) == count
        np.testing.assert_array_equal(out, expected)


def test_comments_and_docstrings_go_along():
    text = Printer(module_of(TEXT)).text()
    assert "/*\n * Sums of what\n * is weighted.\n */\n/* Return the sum of each entry times its place. */" in text
    assert "/* by place */" in text


def test_a_long_line_is_broken_at_spaces_and_keeps_its_words():
    line = "    total = " + " + ".join(f"w[{k}]" for k in range(60)) + ";"
    lines = wrap_line(line).split("\n")
    assert len(lines) > 3
    assert all(len(part) <= WIDTH for part in lines)
    assert " ".join("\n".join(lines).split()) == " ".join(line.split())
    assert all(part.startswith(3 * "    ") for part in lines[1:])
