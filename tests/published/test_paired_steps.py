"""Paired steps of US patent 4,843,294 (1989): a second step half a period after the first cancels a mode's swing.

Case J of docs/validation.md.
"""

import pytest

from stiff_motor import pair_over_step, pair_over_step_in_closed_form


@pytest.mark.parametrize(("damping", "published"), [(0.005, 0.016), (0.01, 0.031), (0.102, 0.275)])
def test_a_pair_leaves_the_share_of_its_closed_form(damping, published, note):
    """Truth: 1 - exp(-pi zeta/sqrt(1 - zeta^2)) of the swing of one step, by the kernel, to 1 %."""
    left = pair_over_step(damping)
    note(f"paired steps, zeta {damping}: {left:.6f} of the swing, closed form {published}")
    assert pair_over_step_in_closed_form(damping) == pytest.approx(published, abs=5e-4)
    assert left == pytest.approx(pair_over_step_in_closed_form(damping), rel=0.01)
