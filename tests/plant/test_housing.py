"""The flexible housing. Truth: transfer functions typed by hand."""

import numpy as np
import pytest
from sympy import Symbol

from hand_typed_blocks import (
    housing_response,
)
from layouts import paper_with


@pytest.mark.parametrize("form", ["paper", "unit_dc"])
def test_a_housing_of_two_modes_is_their_sum(form):
    """Truth: transfer functions by hand, the second mode's gain of either sign."""
    second = {"gain": -0.8, "frequency": 2500.0, "damping": 0.04}
    m = paper_with({"housing": {"form": form, "second_mode": second}})
    named = {str(s): v for s, v in zip(m.plant.parameters, m.kernel_values(), strict=True)}
    system = m.plant.filter
    A, B = (np.array(matrix.subs(named), dtype=float) for matrix in (system.A, system.B))
    seen = m.plant.outputs["torque"].subs(named)
    C = np.array([float(seen.diff(s)) for s in system.states])
    k = list(map(str, system.inputs)).index("T_res")
    through = float(seen.diff(Symbol("T_res")))
    for hz in (0.1, 200.0, 397.9, 700.0, 888.0, 3000.0):
        s = 2j * np.pi * hz
        z = np.linalg.solve(s * np.eye(len(A)) - A, B)
        modes = ((4.6, 5578.0, 0.095), (-0.8, 2500.0, 0.04))
        assert C @ z[:, k] + through == pytest.approx(housing_response(s, -1.0, form, modes), rel=1e-9)
