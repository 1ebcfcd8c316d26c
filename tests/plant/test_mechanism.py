"""A mechanism: a plant with values. Truth: differences of its maps, and the relations that its blocks declare."""

import numpy as np
import pytest

from mechid.campaign import catalogue_mechanism
from mechid.parameter import Status


@pytest.fixture
def mechanism():
    return catalogue_mechanism()


def test_the_kernels_jacobian_is_that_of_differences(mechanism):
    """Truth: central differences of `kernel_values`; a tied parameter moves with its master."""
    jacobian = mechanism.kernel_jacobian()
    assert "stepper.back_emf_constant" not in jacobian
    for name, column in jacobian.items():
        value = mechanism.value(name)
        step = 1e-6 * max(abs(value), 1.0)
        ends = [mechanism.kernel_values({name: value + s}) for s in (step, -step)]
        np.testing.assert_allclose(column, (ends[0] - ends[1]) / (2.0 * step), rtol=1e-6, atol=1e-7)


def test_a_tied_parameter_has_its_masters_value(mechanism):
    moved = mechanism.with_values({"stepper.torque_constant": 0.3})
    assert moved.value("stepper.back_emf_constant") == 0.3
    assert mechanism.value("stepper.back_emf_constant") == mechanism.value("stepper.torque_constant") != 0.3


def test_harmonics_are_counted_in_a_turn_of_the_rotor(mechanism):
    """Truth: 100 poles are 50 electrical periods a turn; detents of 1.8 and 3.6 deg are 200 and 100 periods."""
    assert mechanism.electrical_periods == pytest.approx(50.0)
    periods = [360.0 / mechanism.value(f"stepper.detent.{k}.period_deg") for k in (0, 1)]
    assert sorted(periods) == [100.0, 200.0]


def test_values_that_cannot_stand_beside_others_are_named(mechanism):
    """Truth: static friction is never below Coulomb friction, and poles come in pairs."""
    assert list(mechanism.contradictions()) == []
    low = 0.5 * mechanism.value("friction.coulomb")
    wrong = dict(mechanism.with_values({"friction.static": low, "stepper.poles": 99.0}).contradictions())
    assert set(wrong) == {"friction.static", "stepper.poles"}
    assert wrong["friction.static"].endswith(f"start at {mechanism.value('friction.coulomb'):.9g} or above")
    assert "come in pairs" in wrong["stepper.poles"]


def test_with_free_holds_all_others_and_frees_none(mechanism):
    """Truth: the status of each parameter before."""
    held = mechanism.with_free(("gear.stiffness", "stepper.poles"))
    assert [q.name for q in held.free] == ["gear.stiffness"]
    assert held.parameters["gear.damping"].status is Status.KNOWN
    assert len(mechanism.free) > 1
