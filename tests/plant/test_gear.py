"""Gears. Truth: a start typed by hand, and its derivatives by complex steps."""

import numpy as np
import pytest

from hand_typed_blocks import (
    kinematics,
)
from layouts import LAYOUTS, paper_with
from mechid.kernel.equations import equations_of
from random_states import values


@pytest.mark.parametrize("name", ["kinematic_error", "tooth mesh"])
def test_a_gear_with_kinematic_error_starts_unwound(name):
    """Truth: `hand_typed_blocks`: no twist at the start, whatever the error; its derivatives by differences."""
    m = paper_with(LAYOUTS[name])
    orders = tuple(
        m.value(f"gear.kinematic_error.{k}.order") for k in range(m.plant.layout.count("gear.kinematic_error"))
    )
    start, p, theta_0 = equations_of(m.plant).initial, m.kernel_values(), np.radians(2000.0)
    others = np.zeros(len(m.plant.inputs)), (0.0, 0.0)

    def begun(p):
        return start((theta_0,), *others, p)

    x = dict(zip(map(str, equations_of(m.plant).states), begun(p), strict=True))
    twist, _, _ = kinematics(x["alpha"], 0.0, x["alpha_gear"], 0.0, orders, values(m))
    assert x["alpha"] == pytest.approx(theta_0 / 50.0, rel=1e-12)
    assert abs(x["alpha_gear"] - x["alpha"] / 50.0) > 1e-5
    assert abs(twist) < 1e-16
    slopes = start.by_parameter((theta_0,), *others, p)
    for k, step in enumerate(1e-6 * np.maximum(np.abs(p), 1e-4)):
        move = step * np.eye(p.size)[k]
        np.testing.assert_allclose((begun(p + move) - begun(p - move)) / (2 * step), slopes[:, k], rtol=1e-6, atol=1e-9)
