"""Which column becomes what. Truth: the rules of the contract, one by one, and a line for every refusal."""

from dataclasses import dataclass

import pytest

from mechid.errors import RecordError
from mechid.records import ChannelSpec, RecordSpec, Role
from mechid.records.columns import choose_columns
from mechid.records.table import Column
from records_read import torque


@dataclass
class Head:
    """A table that is nothing but its headers."""

    headers: tuple
    is_ordered: bool = True

    @property
    def columns(self):
        return tuple(Column(name=header) for header in self.headers)

    def error(self, message, row=None):
        return RecordError(message)


def choose(columns, *channels, rate=None):
    spec = RecordSpec(name="run", path="run.csv", sample_rate_hz=rate, channels=channels)
    return choose_columns(Head(columns), spec)


CHOSEN = {  # headers, channels asked for, rate -> index of the time, indices of the channels, their scales
    "default": (("time_s", "torque_Nm"), (), None, 0, [1], [1.0]),
    "default with more columns": (("t", "M [mNm]", "x"), (), None, 0, [1], [1e-3]),
    "default without header": (("", ""), (), None, 0, [1], [1.0]),
    "rate": (("M", "x"), (), 1e4, None, [0], [1.0]),
    "rate, one column": (("",), (), 1e4, None, [0], [1.0]),
    "name": (("t", "a", "Mz"), (torque("Mz"),), None, 0, [2], [1.0]),
    "name without its unit": (("t", "a", "Mz [mNm]"), (torque("Mz"),), None, 0, [2], [1e-3]),
    "name with its unit": (("t", "Mz_Nm", "Mz_mNm"), (torque("Mz_mNm"),), None, 0, [2], [1e-3]),
    "exact name first": (("t", "Mz_Nm", "Mz"), (torque("Mz"),), None, 0, [2], [1.0]),
    "index": (("t", "a", "a"), (torque(2),), None, 0, [2], [1.0]),
    "unit and gain": (("t", "Mz"), (torque("Mz", unit="mNm", gain=-2.0),), None, 0, [1], [-2e-3]),
    "unit twice": (("t", "Mz [N m]"), (torque("Mz", unit="N*m"),), None, 0, [1], [1.0]),
    "named time": (("Mz", "Time (s)"), (torque("Mz"),), None, 1, [0], [1.0]),
    "time of a name of its own": (("x", "Mz"), (torque("Mz"),), None, 0, [1], [1.0]),
    "rate and named time": (("t_s", "Mz"), (torque("Mz"),), 1e4, 0, [1], [1.0]),
    "rate and no time": (("x", "Mz"), (torque("Mz"),), 1e4, None, [1], [1.0]),
    "a name like a unit": (
        ("t", "u_A"),
        (ChannelSpec(quantity="voltage_phase_a", column="u_A", unit="V"),),
        None,
        0,
        [1],
        [1.0],
    ),
}


@pytest.mark.parametrize("name", CHOSEN)
def test_the_columns_are_chosen(name):
    columns, channels, rate, time, indices, scales = CHOSEN[name]
    layout = choose(columns, *channels, rate=rate)
    assert (layout.time.index if layout.time else None) == time
    assert [chosen.index for chosen in layout.channels] == indices
    assert [chosen.scale for chosen in layout.channels] == pytest.approx(scales)
    assert all(chosen.warning is None for chosen in layout.channels)


def test_the_time_is_converted():
    assert choose(("t/ms", "M")).time.scale == pytest.approx(1e-3)


def test_a_torque_that_is_not_where_nobody_said_is_warned_of():
    """Truth: the four columns of a program that writes the temperature first."""
    (chosen,) = choose(["time_s", "Temperature", "Fx", "Mz [N*m]"]).channels
    assert chosen.index == 1
    assert 'is it not Mz? write channels = [{ quantity = "torque", column = "Mz" }]' in chosen.warning


@pytest.mark.parametrize("columns", [["time_s", "Mz"], ["t", "y", "z"], ["t", "Drehmoment", "Mz"]])
def test_a_torque_where_it_is_expected_is_not(columns):
    (chosen,) = choose(columns).channels
    assert chosen.warning is None


def test_the_role_is_kept():
    layout = choose(("t", "uA"), ChannelSpec(quantity="voltage_phase_a", column="uA", role=Role.INPUT))
    assert layout.channels[0].role is Role.INPUT


def test_a_unit_in_brackets_that_the_campaign_overrides_is_said():
    """A transducer recorded in volts, with its sensitivity as gain."""
    layout = choose(("t", "Mz [V]"), torque("Mz", unit="N*m", gain=0.5))
    assert layout.channels[0].scale == 0.5
    assert layout.channels[0].warning == ('column "Mz [V]": read in "N*m", as the campaign says, not in "V"')


CONTAINER = (
    Column(name="t", path="a/t", samples=9),
    Column(name="Mz", path="a/Mz", samples=9),
    Column(name="t", path="b/t", samples=9),
    Column(name="Mz", path="b/Mz", samples=9),
)


@dataclass
class Container(Head):
    """A table whose columns have places in groups, and no order."""

    is_ordered: bool = False

    @property
    def columns(self):
        return self.headers


@pytest.mark.parametrize(("path", "index", "time"), [("a/Mz", 1, 0), ("/b/Mz", 3, 2)])
def test_a_path_chooses_a_column_and_the_time_beside_it(path, index, time):
    spec = RecordSpec(name="run", path="run.h5", channels=(torque(path),))
    layout = choose_columns(Container(CONTAINER), spec)
    assert (layout.channels[0].index, layout.time.index) == (index, time)


def test_two_units_of_one_column_must_agree():
    columns = (Column(name="t"), Column(name="Mz_mNm", unit="N*m"))
    with pytest.raises(RecordError, match='the file states two units, "N\\*m" and "mNm"'):
        choose_columns(Container(columns), RecordSpec(name="run", path="run.h5", channels=(torque("Mz"),)))


REFUSED = {
    "one column": (("M",), (), None, "one column only; add a time column before it, or give sample_rate_hz"),
    "time as torque": (
        ("time_s", "torque_Nm"),
        (),
        1e4,
        'column "time_s": with sample_rate_hz and no channels the first column is the torque; '
        "leave sample_rate_hz out, or name the channels",
    ),
    "unknown column": (
        ("t", "Mz"),
        (torque("Mx"),),
        None,
        'torque: unknown column "Mx"; the file has "t", "Mz"',
    ),
    "misspelt column": (
        ("t", "torque_Nm"),
        (torque("torqe"),),
        None,
        'torque: unknown column "torqe"; did you mean "torque"?',
    ),
    "name without header": (
        ("", ""),
        (torque("Mz"),),
        None,
        'torque: unknown column "Mz"; the file has no header, give the index, 0 to 1',
    ),
    "index": (("t", "Mz"), (torque(2),), None, "torque: no column 2; they go from 0 to 1"),
    "negative index": (("t", "Mz"), (torque(-1),), None, "torque: no column -1; they go from 0 to 1"),
    "ambiguous": (
        ("t", "Mz", "Mz"),
        (torque("Mz"),),
        None,
        'torque: 2 columns "Mz"; give the index from 0',
    ),
    "same quantity": (
        ("t", "a", "b"),
        (torque("a"), torque("b")),
        None,
        "torque: two channels of one record; keep one of them",
    ),
    "same column": (
        ("t", "a"),
        (torque("a"), ChannelSpec(quantity="force", column="a")),
        None,
        'force: column "a" is already torque',
    ),
    "no time": (("Mz", "x"), (torque("Mz"),), None, "no time column; give sample_rate_hz"),
    "unit of the header": (
        ("t", "Mz [V]"),
        (),
        None,
        'column "Mz [V]": unit "V" does not measure torque; expected N*m or a multiple of it; '
        "if that is no unit, name the right one in channels",
    ),
    "unknown unit of the header": (
        ("t", "Mz [-]"),
        (),
        None,
        'column "Mz [-]": unknown unit "-" for torque; expected N*m or a multiple of it; '
        "if that is no unit, name the right one in channels",
    ),
    "unit of the time": (
        ("torque_Nm", "time_s"),
        (),
        None,
        'column "time_s": unit "s" does not measure torque; expected N*m or a multiple of it; '
        'if that is no unit, name the right one in channels; column "time_s" is taken for the torque by its place; '
        'is it not torque? write channels = [{ quantity = "torque", column = "torque" }]',
    ),
    "unit of the campaign": (
        ("t", "Mz"),
        (torque("Mz", unit="A"),),
        None,
        'column "Mz": unit "A" does not measure torque; expected N*m or a multiple of it',
    ),
    "units that differ": (
        ("t", "Mz [mNm]"),
        (torque("Mz", unit="N*m"),),
        None,
        'column "Mz [mNm]": its unit contradicts unit = "N*m" of the campaign; correct one',
    ),
    "unknown quantity": (
        ("t", "Mz"),
        (ChannelSpec(quantity="torqe", column="Mz"),),
        None,
        'column "Mz": unknown quantity "torqe"; did you mean "torque"?',
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_request_that_the_file_cannot_meet_is_refused(name):
    columns, channels, rate, message = REFUSED[name]
    with pytest.raises(RecordError) as caught:
        choose(columns, *channels, rate=rate)
    assert str(caught.value) == message
