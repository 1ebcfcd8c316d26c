"""The text of a batch. Truth: the kernel's own functions, both run by the interpreter, set by set."""

import ast
import math

import numpy as np
import pytest

from golden_variants import VARIANTS
from layouts import mechanism_of
from mechid.kernel.batch.source import SETS, fingerprint, generate
from mechid.kernel.compiled import kernel_for


@pytest.fixture(scope="module")
def kernel():
    return kernel_for(mechanism_of(VARIANTS["direct_torque_drive"]).plant)


def interpreted(text, names):
    """Return what a text's integers and its functions, without their compiler, make of given names."""
    tree, known = ast.parse(text), dict(names) | {"in_vectors": lambda: None, "np": np, "math": math}
    for node in tree.body:
        if isinstance(node, ast.FunctionDef):
            node.decorator_list, node.returns = [], None
            for argument in node.args.args:
                argument.annotation = None
        elif not isinstance(node, ast.Assign):
            continue
        exec(compile(ast.Module([node], []), "text", "exec"), known)
    return known


def test_a_step_of_all_sets_is_the_step_of_each(kernel):
    """Truth: `step` and `outputs` of the kernel on one set's numbers after another; a step turns a sine by little."""
    one = interpreted(kernel.text, vars(kernel.module))
    many = interpreted(generate(kernel.text, kernel.module), vars(kernel.module))
    x, k, new, mid = (one[f"AT_{name}"] for name in ("X", "K", "X_NEW", "MID"))
    rows, states = max(one["SIZE"], many["LENGTH"] + 1), one["NX"]
    rng = np.random.default_rng(2)
    w = rng.normal(size=(rows, SETS))
    w[many["LENGTH"]] = rng.uniform(1e-4, 1e-3, SETS)
    flat, y = w.flatten(), np.zeros(one["NY"] * SETS)
    many["step"](flat, x, k, new, mid)
    many["outputs"](flat, new, y, 0)
    for s in range(SETS):
        own, y_own = w[:, s].copy(), np.zeros(one["NY"])
        one["step"](own, x, k, w[many["LENGTH"], s], new, mid)
        one["outputs"](own, new, y_own, 0)
        np.testing.assert_allclose(flat.reshape(w.shape)[new : new + states, s], own[new : new + states], rtol=1e-13)
        np.testing.assert_allclose(y.reshape(-1, SETS)[:, s], y_own, rtol=1e-13)
        assert not np.array_equal(own[new : new + states], w[new : new + states, s])


def test_another_kernel_has_another_batch(kernel):
    """Truth: the digest of text and generator."""
    assert fingerprint(kernel.text) == fingerprint(kernel.text)
    assert fingerprint(kernel.text) != fingerprint(kernel.text + " ")
