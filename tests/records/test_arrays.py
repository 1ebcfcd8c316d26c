"""Files that hold arrays. Truth: the arrays that were written, and what no channel can be."""

import numpy as np
import pytest

from instrument_files import CURRENT, RATE, TIME, TORQUE
from mechid.records import ChannelSpec
from records_read import read, refused, torque

ARRAYS = {
    "complex": (TORQUE + 1j, "complex numbers; a record needs real ones"),
    "three dimensions": (np.zeros((4, 16, 3)), "4 x 16 x 3 values; a channel has one dimension"),
    "a matrix": (np.zeros((64, 64)), "64 x 64 values; a matrix is no channel"),
    "texts": (np.array(["a", "b"]), "no numbers (<U1)"),
    "empty": (np.zeros(0), "it is empty"),
    "another length": (TORQUE[:40], 'column "time" has 64 samples, column "x" has 40'),
    "beyond float64": (np.full(64, 2**60), "whole numbers beyond 2^53, which have no exact float64"),
    "dead": (np.zeros(64), "the channel is dead"),
    "not finite": (np.where(np.arange(64) == 9, np.nan, TORQUE), 'sample 9: column "x": nan is not a finite number'),
    "short": (TORQUE[:15], "samples"),
}


@pytest.mark.parametrize("name", ARRAYS)
def test_an_array_that_is_no_channel_is_refused_with_the_reason(name, tmp_path):
    values, reason = ARRAYS[name]
    np.savez(tmp_path / "run.npz", time=TIME, x=values)
    message = refused(tmp_path / "run.npz", torque("x"), time=ChannelSpec(quantity="time", column="time"))
    assert reason in message


def test_objects_are_not_unpickled(tmp_path):
    np.save(tmp_path / "run.npy", np.array([{}, {}], dtype=object), allow_pickle=True)
    assert "damaged, or not an .npy file" in refused(tmp_path / "run.npy", torque(0))


def test_series_side_by_side_are_columns_of_their_own(tmp_path):
    both = np.stack((TORQUE, CURRENT))
    np.savez(tmp_path / "run.npz", across=both, down=both.T)
    for column in ("across/1", "down/1"):
        record = read(tmp_path / "run.npz", torque(column), sample_rate_hz=RATE)
        np.testing.assert_array_equal(record.channel("torque").data, CURRENT)
    message = refused(tmp_path / "run.npz", torque("down"), sample_rate_hz=RATE)
    assert message.endswith('2 columns "down"; give the path: "down/0" or "down/1"')
