"""Gear laws. Truth: a torque without damping is the derivative of the stored energy."""

import pytest
import sympy as sp

from mechid.plant.gear_laws import LAWS, D, twist, twist_rate


@pytest.mark.parametrize("law", LAWS)
def test_the_torque_is_the_derivative_of_the_energy(law):
    chosen = LAWS[law]()
    elastic = chosen.torque.subs(twist_rate, 0)
    assert sp.simplify(sp.diff(chosen.energy, twist) - elastic) == 0
    assert sp.diff(chosen.torque, twist_rate).subs(sp.Symbol("contact"), 1) == D


def test_the_energy_is_continuous_where_the_stiffness_changes():
    """Truth: the energy of a broken line has no step at its kinks, whichever mode holds there."""
    chosen = LAWS["piecewise_linear"]()
    values = dict(
        zip(
            sp.symbols("K_s1 K_s2 K_s3 T_s1 T_s2"), (400, 900, 1300, sp.Rational(2, 25), sp.Rational(1, 4)), strict=True
        )
    )
    bends = [values[sp.Symbol("T_s1")] / 400]
    bends.append(bends[0] + (values[sp.Symbol("T_s2")] - values[sp.Symbol("T_s1")]) / 900)
    for bend, (inner, outer) in zip(bends, (("low", "mid_up"), ("mid_up", "high_up")), strict=True):
        here, there = (
            chosen.energy.subs(chosen.switch.modes[mode]).subs(values).subs(twist, bend) for mode in (inner, outer)
        )
        assert sp.nsimplify(here) == sp.nsimplify(there) > 0
