"""Scaling, fill values and valid ranges that a file states. Truth: the torque that was packed by the CF conventions."""

import numpy as np
import pytest

from mechid.checks.data_file import file_numbers
from mechid.errors import RecordError
from mechid.records import Conditioning
from mechid.records.undeclared import Hints, read_bare
from packed_files import COUNTS, write_hdf5
from records_read import read, refused, torque

GAP = [50, 51, 52]


def with_gap(fill, dtype=np.int16):
    numbers = COUNTS.astype(dtype)
    numbers[GAP] = fill
    return numbers


def packed(attributes, numbers=COUNTS):
    return numbers, {"units": "N m", **attributes}


APPLIED = {
    "a scale and an offset": (packed({"scale_factor": 1e-4, "add_offset": 0.1}), 1e-4 * COUNTS + 0.1),
    "a scale": (packed({"scale_factor": np.float32(0.5)}), 0.5 * COUNTS),
    "an offset": (packed({"add_offset": -3}), COUNTS - 3.0),
    "a scale of floats": (packed({"scale_factor": 2.0}, COUNTS.astype(float)), 2.0 * COUNTS),
    "a scale as text": (packed({"scale_factor": "1e-4"}), 1e-4 * COUNTS),
    "a scale in an array of one": (packed({"scale_factor": np.array([1e-4])}), 1e-4 * COUNTS),
    "a scale in a unit of the file": (packed({"units": "mN m", "scale_factor": 0.1}), 1e-4 * COUNTS),
    "unsigned numbers": (
        packed(
            {"_Unsigned": "true", "scale_factor": 1e-3}, (COUNTS + np.int32(40000)).astype(np.uint16).view(np.int16)
        ),
        1e-3 * (COUNTS + 40000.0),
    ),
    "bytes": (packed({"scale_factor": 0.01}, (COUNTS // 100).astype(np.int8)), 0.01 * (COUNTS // 100)),
}


@pytest.mark.parametrize("name", APPLIED)
def test_a_scaling_of_the_conventions_is_applied(name, tmp_path):
    (numbers, attributes), truth = APPLIED[name]
    path = tmp_path / "run.h5"
    write_hdf5(path, numbers, **attributes)
    record = read(path, torque("torque"))
    np.testing.assert_allclose(record.channel("torque").data, truth, rtol=1e-6, atol=1e-12)
    assert record.warnings == ()
    np.testing.assert_allclose(read_bare(path)[0].channel("torque").data, truth, rtol=1e-6, atol=1e-12)


SCALE = {"scale_factor": 1e-4}
NAN = np.where(np.isin(np.arange(200), GAP), np.nan, COUNTS)
MISSING = {
    "a fill value": (packed({**SCALE, "_FillValue": np.int16(-9999)}, with_gap(-9999)), 1e-4 * COUNTS),
    "a missing value": (packed({**SCALE, "missing_value": -9999.0}, with_gap(-9999)), 1e-4 * COUNTS),
    "several missing values": (
        packed(
            {**SCALE, "missing_value": np.array([-9999, -8888])},
            np.where(np.arange(200) % 50 == 7, -8888, with_gap(-9999)),
        ),
        None,
    ),
    "a fill value without a scale": (packed({"_FillValue": -9999.0}, with_gap(-9999, float)), COUNTS),
    "a fill value of 32 bits": (
        packed({"_FillValue": np.float32(-999.9)}, with_gap(-999.9, np.float32)),
        COUNTS,
    ),
    "a fill value of 64 bits for numbers of 32": (packed({"_FillValue": -999.9}, with_gap(-999.9, np.float32)), COUNTS),
    "a range": (packed({**SCALE, "valid_range": np.array([-8000, 8000], np.int16)}, with_gap(30000)), 1e-4 * COUNTS),
    "a least number": (packed({**SCALE, "valid_min": np.int16(-8000)}, with_gap(-30000)), 1e-4 * COUNTS),
    "a largest number": (packed({**SCALE, "valid_max": np.int16(8000)}, with_gap(30000)), 1e-4 * COUNTS),
    "a range of the values": (packed({**SCALE, "valid_range": np.array([-0.8, 0.8])}, with_gap(30000)), 1e-4 * COUNTS),
    "a range of the numbers, as floats": (
        packed({**SCALE, "valid_range": np.array([-8e3, 8e3])}, with_gap(30000)),
        1e-4 * COUNTS,
    ),
    "a range as text": (packed({**SCALE, "valid_range": "-8000, 8000"}, with_gap(30000)), 1e-4 * COUNTS),
    "a range of floats": (packed({"valid_range": np.array([-8e3, 8e3])}, with_gap(3e4, float)), COUNTS),
    "an unsigned fill value": (
        packed(
            {"_Unsigned": "true", "_FillValue": np.int16(-1), **SCALE},
            np.where(np.isin(np.arange(200), GAP), 65535, COUNTS + np.int32(40000)).astype(np.uint16).view(np.int16),
        ),
        1e-4 * (COUNTS + 40000.0),
    ),
    "numbers of 64 bits with the largest as fill value": (
        packed({**SCALE, "_FillValue": np.int64(2**63 - 1)}, with_gap(2**63 - 1, np.int64)),
        1e-4 * COUNTS,
    ),
}


@pytest.mark.parametrize("name", MISSING)
def test_what_is_no_measurement_is_missing(name, tmp_path):
    """Missing samples are refused, or bridged where the campaign allows it, as those of every other format."""
    (numbers, attributes), truth = MISSING[name]
    path = tmp_path / "run.h5"
    write_hdf5(path, numbers, **attributes)
    assert "nan is not a finite number; max_gap_s = ... allows to bridge" in refused(path, torque("torque"))
    channel = read(path, torque("torque"), conditioning=Conditioning(max_gap_s=0.01)).channel("torque")
    if truth is None:
        assert channel.bridged.tolist() == [7, *GAP, 57, 107, 157]
        return
    assert channel.bridged.tolist() == GAP
    kept = np.setdiff1d(np.arange(200), GAP)
    np.testing.assert_allclose(channel.data[kept], np.asarray(truth)[kept], rtol=1e-6)
    assert read_bare(path)[0].channel("torque").bridged.tolist() == GAP


NOT_APPLIED = {
    "gain": ({"gain": 0.5}, "gain = 0.5"),
    "Gain": ({"Gain": 2}, "Gain = 2"),
    "scale": ({"scale": 1e-4}, "scale = 0.0001"),
    "scale factor in other letters": ({"ScaleFactor": 1e-4}, "ScaleFactor = 0.0001"),
    "offset": ({"offset": 0.25}, "offset = 0.25"),
    "slope and intercept": ({"slope": 2.0, "intercept": 1.0}, "intercept = 1, slope = 2"),
    "calibration": ({"calibration": 0.02}, "calibration = 0.02"),
    "calibration in words": ({"calibration": "0.5 N m/V"}, 'calibration = "0.5 N m/V"'),
    "resolution of integers": ({"resolution": 1e-4}, "resolution = 0.0001"),
    "sensitivity of integers": ({"sensitivity": 2.5}, "sensitivity = 2.5"),
    "a polynomial": ({"coefficients": np.array([0.1, 2.0])}, "coefficients = 0.1, 2"),
    "a scale of each series": ({"scale_factor": np.array([1e-4, 2e-4])}, "scale_factor = 0.0001, 0.0002"),
    "a scale in words": ({"scale_factor": "see manual"}, 'scale_factor = "see manual"'),
    "a range without an end": ({"valid_range": np.array([1.0])}, "valid_range = 1"),
    "a scale of nothing": ({"scale_factor": 0.0}, "scale_factor = 0"),
    "one of the conventions and another": ({"scale_factor": 1e-4, "gain": 4.0}, "gain = 4"),
}
NEUTRAL = {
    "gain": {"gain": 1.0},
    "offset": {"offset": 0},
    "scale and offset": {"scale": np.float32(1.0), "offset": 0.0},
    "a date": {"calibration": "2024-05-06"},
    "a text": {"scale": "linear"},
    "no scaling": {"serial": 12, "range": 50.0, "rate": 1000.0},
    "data of the instrument": {"sensitivity": 2.5, "resolution": 1e-4},
    "a flag": {"calibration": True},
}


@pytest.mark.parametrize("name", NOT_APPLIED)
def test_a_scaling_that_is_not_understood_is_refused_unless_the_campaign_settles_it(name, tmp_path):
    attributes, said = NOT_APPLIED[name]
    path = tmp_path / "run.h5"
    write_hdf5(path, COUNTS, units="N m", **attributes)
    remedy = 'channels = [{ quantity = "torque", column = "run/torque", unit = "N*m", gain = ... }]'
    for asked in ({}, {"unit": "N*m"}, {"gain": 2.0}):
        message = refused(path, torque("torque", **asked))
        assert f"the file states {said}, but not how to apply it" in message
        assert message.endswith(remedy)
    scale = 1e-4 if "gain" in attributes and "scale_factor" in attributes else 1.0
    settled = read(path, torque("torque", unit="N*m", gain=1.0))
    np.testing.assert_allclose(settled.channel("torque").data, scale * COUNTS)
    with pytest.raises(RecordError, match="the file states"):
        read_bare(path)
    (looked_at,) = read_bare(path, Hints(columns=("torque",), quantity="torque", unit="N*m"))
    np.testing.assert_allclose(looked_at.channel("torque").data, scale * COUNTS)


@pytest.mark.parametrize("name", NEUTRAL)
def test_an_attribute_that_scales_nothing_is_left(name, tmp_path):
    path = tmp_path / "run.h5"
    write_hdf5(path, 1.0 * COUNTS, units="N m", **NEUTRAL[name])
    np.testing.assert_array_equal(read(path, torque("torque")).channel("torque").data, COUNTS)
    assert read_bare(path)[0].warnings == ()


def test_a_sensitivity_of_numbers_without_a_unit_is_a_scaling(tmp_path):
    path = tmp_path / "run.h5"
    write_hdf5(path, 1.0 * COUNTS, sensitivity=2.5)
    assert "the file states sensitivity = 2.5" in refused(path, torque("torque"))


def test_the_list_of_a_files_columns_says_what_is_not_applied(tmp_path):
    path = tmp_path / "run.h5"
    write_hdf5(path, COUNTS, units="N m", gain=0.5)
    assert file_numbers(path)["warnings"] == ['run.h5: column "run/torque": gain = 0.5 is not applied']


def test_a_stated_unit_leaves_the_doubt_about_integers(tmp_path):
    """Truth: integers in N m are more likely the counts of a converter than a torque; the campaign may say that not."""
    path = tmp_path / "run.h5"
    write_hdf5(path, COUNTS, units="N m")
    (said,) = read(path, torque("torque")).warnings
    assert said == (
        'run.h5: column "run/torque": integers, read in "N m" as the file says; are they raw counts? then give unit '
        'and gain, otherwise unit = "N m"'
    )
    (looked_at,) = read_bare(path)
    assert looked_at.warnings == (said,)
    assert read(path, torque("torque", unit="N m")).warnings == ()
    assert read(path, torque("torque", gain=1.0)).warnings == ()
    assert read_bare(path, Hints(columns=("torque",), unit="N m"))[0].warnings == ()
