"""Fits of measured records by kernels for several processors; truth: one another, to a tenth of a sigma.

What such a record does not tell, rounding may decide: the status of a parameter and where its valley is left.
"""

import pytest

from processors import differences, fits

pytestmark = [pytest.mark.data, pytest.mark.slow]


@pytest.mark.parametrize("name", ["robot_axis", "stepper", "emps", "pendulum"])
def test_a_measured_fit_is_the_same_on_every_processor(example, name, tmp_path):
    told = list(differences(fits(str(example(name)), tmp_path)))
    assert not told, "\n".join(told)
