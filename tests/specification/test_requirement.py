"""Masks and directions. Truth: values by hand."""

import numpy as np
import pytest

from mechid.records import Mounting
from mechid.specification.requirement import Mask, direction_of, unit_of

MASK = Mask(np.array([10.0, 100.0, 1000.0]), np.array([1.0, 10.0, 0.1]))


def test_a_mask_is_straight_on_logarithmic_axes():
    assert MASK.limit_at(np.array([1.0, 10.0, 10.0**1.5, 100.0, 10.0**2.5, 1e3, 2e3])) == pytest.approx(
        [np.inf, 1.0, 10.0**0.5, 10.0, 1.0, 0.1, np.inf]
    )
    assert MASK.bands == [(10.0, 100.0, 1.0), (100.0, 1000.0, 10.0)]


@pytest.mark.parametrize(
    ("quantity", "mounting", "direction"),
    [
        ("force_x", None, "fx"),
        ("moment_y", None, "my"),
        ("torque", None, "torque"),
        ("torque", Mounting("-x", (0.0, 0.0, 0.0)), "mx"),
        ("rotor_angle", None, None),
    ],
)
def test_a_channel_measures_a_direction(quantity, mounting, direction):
    assert direction_of(quantity, mounting) == direction


def test_units_follow_from_direction_and_kind():
    assert unit_of("fz", "psd") == "N^2/Hz"
    assert unit_of("torque", "band_peak") == "N*m"
