"""A servo to and fro without a load; truth: a least squares on the same data, in the data's own index.

That fit: i = 1.934e-4 a + 2.273e-4 w + 0.0710 sign(w) - 0.0002, in A, rad/s2 and rad/s.
"""

import pytest

from mechid.identification.result.grade import Grade

pytestmark = [pytest.mark.data, pytest.mark.slow]
INERTIA = 1.934e-4


@pytest.fixture(scope="module")
def fit(example, identified):
    return identified(example("servo"))[0]


def test_it_is_followed_without_a_noise_level(fit, figure):
    assert fit.outcome.good
    assert fit.grade is Grade.B
    record = fit.records["to_and_fro"]
    assert record.noise_rests_on == "residual"
    figure("servo: fit from current to rate", record.fit_percent, least=95.0, unit="%")
    figure("servo: followed of 6 s", record.horizon_s, least=5.99, unit="s")


def test_its_inertia(fit, figure):
    p = fit.parameters["load.inertia"]
    figure(
        "servo: inertia over the torque constant, within two standard errors of the index's",
        p.value,
        least=INERTIA - 2.0 * p.std_error,
        most=INERTIA + 2.0 * p.std_error,
        unit="A s2/rad",
    )
