"""The streamed triangle against numpy's QR of the whole matrix."""

import os
import subprocess
import sys

import numpy as np
import pytest

from mechid.identification.output_error.reduction import absorb, combine_triangles, drop_projected_rows


def matrix(n, linear, columns, seed):
    rng = np.random.default_rng(seed)
    return rng.standard_normal((n, linear + 1 + columns))


def streamed(whole, linear, block):
    width = whole.shape[1]
    R = np.zeros((width, width))
    for first in range(0, len(whole), block):
        part = whole[first : first + block]
        absorb(R, np.array(part.T, order="C"), len(part))
    return drop_projected_rows(R, linear, len(whole))


def projected(whole, linear):
    """Return [r J] without what Phi explains, by a dense least squares."""
    if linear == 0:
        return whole
    phi, rest = whole[:, :linear], whole[:, linear:]
    return rest - phi @ np.linalg.lstsq(phi, rest, rcond=None)[0]


@pytest.mark.parametrize("linear", [0, 1, 2])
@pytest.mark.parametrize("block", [1, 7, 64, 1000])
def test_norm_and_gradient_are_those_of_the_dense_problem(linear, block):
    """Truth: numpy on the whole matrix."""
    whole = matrix(257, linear, 5, seed=linear)
    triangle, dense = streamed(whole, linear, block), projected(whole, linear)
    r, J = dense[:, 0], dense[:, 1:]
    assert triangle.norm == pytest.approx(np.linalg.norm(r), rel=1e-12)
    np.testing.assert_allclose(triangle.jacobian.T @ triangle.fun, J.T @ r, rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(triangle.jacobian.T @ triangle.jacobian, J.T @ J, rtol=1e-10, atol=1e-10)


def test_records_join_as_their_rows_do():
    """Truth: the triangle of the stacked rows."""
    parts = [matrix(n, 2, 4, seed=n) for n in (100, 33, 5)]
    joined = combine_triangles([streamed(p, 2, 16) for p in parts])
    dense = np.vstack([projected(p, 2) for p in parts])
    assert joined.norm == pytest.approx(np.linalg.norm(dense[:, 0]), rel=1e-12)
    np.testing.assert_allclose(joined.jacobian.T @ joined.fun, dense[:, 1:].T @ dense[:, 0], rtol=1e-10, atol=1e-10)


REDUCED = """
import numpy as np
from mechid.identification.output_error.reduction import absorb
R = np.zeros((2, 2))
absorb(R, np.array([[3.0, 4.0], [0.0, 5.0]]), 2)
print(abs(R[0, 0]), abs(R[1, 1]))
"""


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".nbc", pytest.param(".nbi", marks=pytest.mark.slow)])
def test_damaged_machine_code_is_made_anew(tmp_path, suffix):
    """Truth: lengths of a right-angled triangle, 5 and 3; damaged machine code that is loaded ends Python."""

    def said():
        environment = {**os.environ, "MECHID_CACHE": str(tmp_path)}
        command = [sys.executable, "-c", REDUCED]
        return subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout.split()

    assert [float(one) for one in said()] == pytest.approx([5.0, 3.0])
    [compiled] = tmp_path.rglob(f"reflections_*{suffix}")
    content = compiled.read_bytes()
    compiled.write_bytes(content[: len(content) // 2] + bytes(len(content) // 2))
    assert [float(one) for one in said()] == pytest.approx([5.0, 3.0])
    [mended] = tmp_path.rglob(f"reflections_*{suffix}")
    assert mended.read_bytes()[len(content) // 2 :] != bytes(len(content) // 2)
