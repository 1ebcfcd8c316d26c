"""The test stand. Truth: transfer functions typed by hand, the filter by its poles on a circle."""

import numpy as np
import pytest

from hand_typed_blocks import (
    stand_response,
)
from layouts import LAYOUTS, paper_with
from random_states import values


def test_the_test_stand_s_response_is_that_of_its_parts_in_a_row():
    """Truth: transfer functions by hand, the Butterworth filter by its poles on a circle; for a torque of the base."""
    m = paper_with({**LAYOUTS["test stand"], "housing": None})
    q, system = values(m), m.plant.filter
    named = {str(s): v for s, v in zip(m.plant.parameters, m.kernel_values(), strict=True)}
    A, B = (np.array(matrix.subs(named), dtype=float) for matrix in (system.A, system.B))
    (seen,) = m.plant.outputs.values()
    C = np.array([float(seen.diff(s).subs(named)) for s in system.states])
    T = {"T_res": -1.0, "T_rg": -q["G"]}  # y = -(T_res + G T_rg)
    for hz in (0.05, 3.0, 300.0, 2500.0, 4000.0):
        s = 2j * np.pi * hz
        z = np.linalg.solve(s * np.eye(len(A)) - A, B)
        for j, u in enumerate(map(str, system.inputs)):
            assert C @ z[:, j] == pytest.approx(stand_response(s, T[u], q, 5), rel=1e-9)
