"""Calibrated loads. Truth: the loads that cross-talk and sensitivities, by matrices, made the channels of."""

import numpy as np
import pytest

from loads_by_hand import record_of
from mechid.errors import RecordError
from mechid.records import Mounting
from mechid.records.calibration import Calibration, calibrate
from mechid.records.components import COMPONENTS

RNG = np.random.default_rng(3)
LOADS = RNG.normal(size=(6, 50))
TO_VOLTS = np.diag([0.1, 0.1, 0.05, 2.0, 2.0, 4.0]) @ (np.eye(6) + 0.03 * RNG.normal(size=(6, 6)))


def calibration(matrix):
    return Calibration(matrix=matrix, in_volts=True, uncertainty=0.005, source="c.csv")


def channels(axis="z", sense=1.0):
    """Return the channels in volts, that about the drive axis as the torque, with its sign."""
    volts = dict(zip(COMPONENTS, TO_VOLTS @ LOADS, strict=True))
    return {
        "torque" if name == f"moment_{axis}" else name: sense * y if name == f"moment_{axis}" else y
        for name, y in volts.items()
    }


@pytest.mark.parametrize(("axis", "sense"), [("z", 1.0), ("-x", -1.0)])
def test_the_loads_come_back(axis, sense):
    data = calibrate(
        record_of(channels(axis[-1], sense)), calibration(np.linalg.inv(TO_VOLTS)), Mounting(axis, (0, 0, 0))
    )
    for name, load in zip(COMPONENTS, LOADS, strict=True):
        own = ("torque", sense * load) if name == f"moment_{axis[-1]}" else (name, load)
        np.testing.assert_allclose(data.channel(own[0]).data, own[1], rtol=1e-12, atol=1e-12)
        assert data.channel(own[0]).unit == ("N" if name.startswith("force") else "N*m")
    assert data.treatments[-1]["step"] == "calibrated"


def test_a_sample_bridged_in_one_channel_is_in_all_loads_made_of_it():
    data = calibrate(
        record_of(channels(), bridged={"force_x": [7]}), calibration(np.linalg.inv(TO_VOLTS)), Mounting("z", (0, 0, 0))
    )
    assert all(channel.bridged.tolist() == [7] for channel in data.channels)


def test_a_component_that_others_are_made_of_has_to_be_there():
    some = {name: y for name, y in channels().items() if name != "force_y"}
    with pytest.raises(RecordError, match="has no force_y, which the calibration of"):
        calibrate(record_of(some), calibration(np.linalg.inv(TO_VOLTS)), Mounting("z", (0, 0, 0)))
    diagonal = calibrate(record_of(some), calibration(np.diag([10.0, 1, 1, 1, 1, 1])), Mounting("z", (0, 0, 0)))
    np.testing.assert_allclose(diagonal.channel("force_x").data, 10.0 * some["force_x"])
