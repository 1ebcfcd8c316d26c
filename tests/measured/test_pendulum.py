"""A geared actuator with a pendulum; truth: what its swing-up was planned with, and the values published for it.

F. Wiebe et al., Torque-limited simple pendulum, Journal of Open Source Software 7 (2022) 3884.
"""

import numpy as np
import pytest

from mechid.records import open_table

pytestmark = [pytest.mark.data, pytest.mark.slow]
GRAVITY = 9.81
PUBLISHED = {"inertia": 0.06259, "unbalance": 0.1022 * GRAVITY}


@pytest.fixture(scope="module")
def fit(example, identified):
    return identified(example("pendulum"))[0]


@pytest.fixture(scope="module")
def planned(data_folder):
    """Return inertia and unbalance that the planned trajectory obeys, to 1e-3: T = J a + b v + W sin(q)."""
    time, q, v, torque = open_table(data_folder / "pendulum" / "data_desired.csv", "data_desired.csv").read(range(4))
    W = np.stack([np.gradient(v, time), v, np.sin(q)], axis=1)
    (J, _, unbalance), left, *_ = np.linalg.lstsq(W, torque, rcond=None)
    assert np.sqrt(left[0] / time.size) < 0.005
    return {"inertia": J, "unbalance": unbalance}


@pytest.mark.parametrize(("name", "unit"), [("inertia", "kg m2"), ("unbalance", "N m")])
def test_what_the_swing_up_was_planned_with(fit, planned, figure, name, unit):
    p = fit.parameters[f"load.{name}"]
    figure(
        f"pendulum: {name}, within two standard errors of the planned {planned[name]:.4g}",
        p.value,
        least=planned[name] - 2.0 * p.std_error,
        most=planned[name] + 2.0 * p.std_error,
        unit=unit,
    )


def test_the_swing_up_is_followed(fit, figure):
    figure(
        "pendulum: fit of the swing-up from torque to angle", fit.records["swing_up"].fit_percent, least=95.0, unit="%"
    )


REGRESSION = {"J": 0.06259, "m c": 0.1022, "viscous": 0.04707, "Coulomb": 0.1839, "offset": -0.07586}
"""As published, by a least squares on T = J a + m c g sin(q) + F_v v + F_c atan(100 v) + offset."""


def test_the_published_regression_with_the_readers_columns(data_folder, figure):
    """mechid offers no inverse dynamics: this least squares is the test's, the columns are the reader's.

    The published filters: Butterworth of third order without delay, at 0.2 of the Nyquist frequency for the speed
    that is differentiated, at 0.1 for acceleration and torque; angle and the speed from it are not filtered.
    """
    from scipy.signal import butter, filtfilt

    name = "data_measured.csv"
    time, q, v, torque = open_table(data_folder / "pendulum" / name, name).read(range(4))
    acceleration = filtfilt(*butter(3, 0.1), np.gradient(filtfilt(*butter(3, 0.2), v), time))
    speed = np.gradient(q, time)
    W = np.stack([acceleration, GRAVITY * np.sin(q), speed, np.arctan(100.0 * speed), np.ones_like(q)], axis=1)
    found = np.linalg.lstsq(W, filtfilt(*butter(3, 0.1), torque), rcond=None)[0]
    for value, (symbol, published) in zip(found, REGRESSION.items(), strict=True):
        figure(f"pendulum: published regression, {symbol}, off by", abs(value / published - 1.0), most=5e-4)


FILTERED = "the published regression leaves 0.85 of 1.14 N m RMS: its filters differ, and its regressors are noisy"


@pytest.mark.xfail(strict=True, raises=AssertionError, reason=FILTERED)
@pytest.mark.parametrize(("name", "unit"), [("inertia", "kg m2"), ("unbalance", "N m")])
def test_the_published_values(fit, figure, name, unit):
    p, published = fit.parameters[f"load.{name}"], PUBLISHED[name]
    figure(
        f"pendulum: {name}, within two standard errors of the published {published:.4g}",
        p.value,
        least=published - 2.0 * p.std_error,
        most=published + 2.0 * p.std_error,
        unit=unit,
    )
