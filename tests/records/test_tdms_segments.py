"""Channels whose segments differ. Truth: what was written into each segment; by TDMS's rule a correction holds."""

import numpy as np
import pytest
from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter

from mechid.errors import RecordError
from mechid.records import ChannelSpec, RecordSpec, read_record
from mechid.records.undeclared import read_bare

RATE = 1000.0
TORQUE = np.sin(0.3 * np.arange(200.0))
HALF = TORQUE.size // 2
BEGUN = np.datetime64("2024-05-06T07:08:09.000000")
ONE = {"unit_string": "mN.m", "wf_increment": 1.0 / RATE, "wf_start_time": BEGUN, "wf_start_offset": 0.0}
SCALED = {
    "NI_Number_Of_Scales": 1,
    "NI_Scaling_Status": "unscaled",
    "NI_Scale[0]_Scale_Type": "Linear",
    "NI_Scale[0]_Linear_Slope": 2.0,
    "NI_Scale[0]_Linear_Y_Intercept": 0.0,
    "NI_Scale[0]_Linear_Input_Source": 0xFFFFFFFF,
}


def later(seconds):
    return BEGUN + np.timedelta64(round(1e6 * seconds), "us")


def write(path, *segments):
    """Write segments of one channel: its properties and samples, or a list of objects."""
    with TdmsWriter(path) as file:
        for segment in segments:
            file.write_segment(segment if isinstance(segment, list) else [ChannelObject("run", "Mz", *segment[::-1])])


def halves(first, second, *more):
    return [(first, TORQUE[:HALF]), (second, TORQUE[HALF:]), *more]


def read(path, **asked):
    channel = ChannelSpec(quantity="torque", column="run/Mz", **asked)
    return read_record(path, RecordSpec(name="run", path="run.tdms", channels=(channel,)))


NOTHING = np.zeros(0)
SAME = {
    "properties stated once": (halves(ONE, {}), 1.0),
    "properties repeated": (halves(ONE, ONE), 1.0),
    "another spelling of the unit": (halves(ONE, {**ONE, "unit_string": "mNm"}), 1.0),
    "the number of samples of each segment": (halves({**ONE, "wf_samples": 1}, {**ONE, "wf_samples": 2}), 1.0),
    "a start that goes on": (halves(ONE, {**ONE, "wf_start_time": later(HALF / RATE)}), 1.0),
    "a start within a sample": (halves(ONE, {**ONE, "wf_start_time": later((HALF + 0.9) / RATE)}), 1.0),
    "an offset that goes on": (halves(ONE, {**ONE, "wf_start_offset": HALF / RATE}), 1.0),
    "an increment that is rounded": (halves(ONE, {**ONE, "wf_increment": (1.0 + 1e-12) / RATE}), 1.0),
    "other properties": (halves({**ONE, "operator": "A"}, {**ONE, "operator": "B"}), 1.0),
    "the same scaling": (halves({**ONE, **SCALED}, {**ONE, **SCALED}), 2.0),
    "a unit that is corrected at the end": (halves(ONE, ONE, ({"unit_string": "N.m"}, NOTHING)), 1e3),
    "properties at the end": (halves({}, {}, (ONE, NOTHING)), 1.0),
    "another channel in between": (
        [(ONE, TORQUE[:HALF]), [ChannelObject("run", "other", TORQUE, {"unit_string": "V"})], (ONE, TORQUE[HALF:])],
        1.0,
    ),
}


@pytest.mark.parametrize("name", SAME)
def test_segments_that_go_on_are_one_series(name, tmp_path):
    segments, factor = SAME[name]
    path = tmp_path / "run.tdms"
    write(path, *segments)
    record = read(path)
    np.testing.assert_allclose(record.channel("torque").data, 1e-3 * factor * TORQUE, rtol=1e-12)
    assert (record.sample_rate_hz, record.time_start_s) == (RATE, 0.0)
    assert record.start_time == str(BEGUN)


GROUP = [
    [GroupObject("run", {**SCALED, "NI_Scale[0]_Linear_Slope": slope}), ChannelObject("run", "Mz", part, ONE)]
    for slope, part in ((2.0, TORQUE[:HALF]), (3.0, TORQUE[HALF:]))
]
OTHER = {
    "another unit": (halves(ONE, {**ONE, "unit_string": "N.m"}), ('unit_string is "mN.m"', '"N.m" from there on')),
    "another unknown unit": (halves(ONE, {**ONE, "unit_string": "furlong"}), ('"mN.m"', '"furlong"')),
    "a unit later": (halves({"wf_increment": 1.0 / RATE}, ONE), ("unit_string is not stated", '"mN.m"')),
    "a unit that comes back": (halves(ONE, {"unit_string": "N.m"}, (ONE, TORQUE)), ('"N.m" from there on',)),
    "another rate": (halves(ONE, {**ONE, "wf_increment": 2.0 / RATE}), ("wf_increment is 0.001", "0.002")),
    "a rate later": (halves({"unit_string": "mN.m"}, ONE), ("wf_increment is not stated", "0.001")),
    "a pause": (
        halves(ONE, {**ONE, "wf_start_time": later(5.0)}),
        ("do not follow each other", "0.1 s by wf_increment", "5 s by wf_start_time", "07:08:09.000000", "07:08:14"),
    ),
    "a pause of two samples": (halves(ONE, {**ONE, "wf_start_time": later((HALF + 2) / RATE)}), ("0.102 s",)),
    "a run that was appended": (halves(ONE, {**ONE, "wf_start_time": later(86400.0)}), ("86400 s",)),
    "a run that was begun before": (halves(ONE, {**ONE, "wf_start_time": later(-60.0)}), ("-60 s",)),
    "an offset with a pause": (halves(ONE, {**ONE, "wf_start_offset": 0.3}), ("0.3 s by wf_start_time",)),
    "another slope": (
        halves({**ONE, **SCALED}, {**ONE, **SCALED, "NI_Scale[0]_Linear_Slope": 3.0}),
        ("NI_Scale[0]_Linear_Slope is 2.0", "3.0"),
    ),
    "a scaling later": (halves(ONE, {**ONE, **SCALED}), ("NI_Number_Of_Scales is not stated",)),
    "another slope of the group": (GROUP, ("NI_Scale[0]_Linear_Slope is 2.0", "3.0")),
    "another gain": (halves({**ONE, "gain": 10.0}, {**ONE, "gain": 20.0}), ("gain is 10.0", "20.0")),
    "the third of three": (
        [(ONE, TORQUE[:50]), (ONE, TORQUE[50:HALF]), ({**ONE, "unit_string": "V"}, TORQUE[HALF:])],
        ('"V" from there on',),
    ),
}


@pytest.mark.parametrize("name", OTHER)
def test_segments_that_differ_are_refused_with_both_values(name, tmp_path):
    segments, said = OTHER[name]
    path = tmp_path / "run.tdms"
    write(path, *segments)
    with pytest.raises(RecordError) as caught:
        read(path, unit="mN*m", gain=1.0)
    with pytest.raises(RecordError) as looked_at:
        read_bare(path)
    for message in (str(caught.value), str(looked_at.value)):
        for part in (*said, f"sample {HALF}", "save each part as a file of its own"):
            assert part in message


def test_one_channel_may_differ_and_the_other_is_read(tmp_path):
    """Truth: the faulty torque is not replaced by the other channel; by its name that one is read, and look says it."""
    path = tmp_path / "run.tdms"
    other = ChannelObject("run", "iA", TORQUE[:HALF], {"wf_increment": 1.0 / RATE, "unit_string": "A"})
    torques = [
        ChannelObject("run", "torque", TORQUE[:HALF], {"wf_increment": 1.0 / RATE, "unit_string": unit})
        for unit in ("N.m", "mN.m")
    ]
    write(path, [RootObject({}), torques[0], other], [torques[1], other])
    with pytest.raises(RecordError, match='torque: column "run/torque": its segments differ'):
        read_record(path, RecordSpec(name="run", path="run.tdms"))
    current = ChannelSpec(quantity="current", column="iA")
    record = read_record(path, RecordSpec(name="run", path="run.tdms", channels=(current,)))
    assert record.channel("current").data.size == TORQUE.size
    (looked_at,) = read_bare(path)
    assert 'column "run/torque": its segments differ' in looked_at.warnings[0]


@pytest.mark.parametrize("level", [GroupObject("run", {}), RootObject({})], ids=["the group's", "the file's"])
def test_a_scaling_of_an_unknown_kind_is_refused_wherever_it_stands(level, tmp_path):
    """Truth: npTDMS takes a scaling from the group, else from the file, and leaves out one that it does not know."""
    path = tmp_path / "run.tdms"
    level.properties = {"NI_Number_Of_Scales": 1, "NI_Scale[0]_Scale_Type": "Reciprocal"}
    write(path, [level, ChannelObject("run", "Mz", TORQUE, ONE)])
    with pytest.raises(RecordError, match='its scaling "Reciprocal" is unknown'):
        read(path)
