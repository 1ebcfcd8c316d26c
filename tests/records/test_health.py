"""Dead and clipped channels. Truth: the samples that were cut, counted by hand; healthy ones pass in silence."""

import tomllib

import numpy as np
import pytest

from mechid.errors import RecordError
from mechid.records import ChannelSpec, RecordSpec, Role, read_record

TIME = np.arange(400) / 1000.0
SINE = 5.0 * np.sin(2.0 * np.pi * 10.0 * TIME + 0.1)


def read(folder, data, **channel):
    path = folder / "run.csv"
    lines = [f"{t!r},{value!r}" for t, value in zip(TIME.tolist(), np.asarray(data).tolist(), strict=True)]
    path.write_text("t,x\n" + "\n".join(lines))
    asked = ChannelSpec(**{"quantity": "torque", "column": "x", **channel})
    return read_record(path, RecordSpec(name="run", path="run.csv", channels=(asked,)))


def test_a_clipped_channel_is_said_with_count_and_line(tmp_path):
    """Four periods cut at +-4: clipped from 0.1 + 2 pi 10 t = asin(0.8), t = 0.0132 s, hence row 14."""
    record = read(tmp_path, np.clip(SINE, -4.0, 4.0))
    assert record.warnings == (
        'run.csv: line 16: "x": torque stays at its extreme for 8 samples or more 8 times, first here: clipped?',
    )


def test_one_limit_alone_is_found_too(tmp_path):
    assert "4 times" in read(tmp_path, np.minimum(SINE, 4.0)).warnings[0]


def held(row, value, samples=20):
    data = SINE.copy()
    data[row : row + samples] = value
    return data


HEALTHY = {
    "sine": SINE,
    "at rest once, at its extreme": held(380, 9.0),
    "at rest at zero": np.abs(np.maximum(SINE, 0.0)),
    "short stretches": np.clip(SINE, -4.99, 4.99),
}


@pytest.mark.parametrize("name", HEALTHY)
def test_a_healthy_channel_is_passed_in_silence(name, tmp_path):
    assert read(tmp_path, HEALTHY[name]).warnings == ()


def test_a_voltage_stays_at_its_limits_by_design(tmp_path):
    assert read(tmp_path, np.clip(SINE, -4.0, 4.0), quantity="voltage_phase_a", unit="V").warnings == ()


@pytest.mark.parametrize("factor", [1e200, 1e-200])
def test_what_nothing_measures_is_refused(tmp_path, factor):
    """Truth: squares of these are no numbers any more; a fit ended in an error of its own."""
    with pytest.raises(RecordError, match=r"no measured size; look at the column, its unit and the number format"):
        read(tmp_path, factor * SINE)


@pytest.mark.parametrize("value", [0.0, -2.5])
def test_a_dead_output_is_refused(tmp_path, value):
    with pytest.raises(RecordError) as caught:
        read(tmp_path, np.full(TIME.size, value))
    message = f'run.csv: "x": torque is constant at {value:g} N*m: the channel is dead'
    assert str(caught.value) == message


def test_a_constant_input_is_only_said(tmp_path):
    record = read(tmp_path, np.full(TIME.size, 2.0), quantity="current_phase_a", role=Role.INPUT)
    assert record.warnings == ('run.csv: "x": current_phase_a is constant at 2 A',)


OTHERS = {
    "dead": ("Trigger", 5.0, "the channel is dead"),
    "of another unit": ("Fx (N)", 1.0, 'unit "N" does not measure torque'),
}


@pytest.mark.parametrize("case", OTHERS)
def test_a_refused_second_column_is_told_with_the_one_that_is_called_a_torque(case, tmp_path):
    """Truth: the line that is to be written reads the file."""
    name, value, said = OTHERS[case]
    rows = [f"{t!r},{value},{y!r}" for t, y in zip(TIME.tolist(), SINE.tolist(), strict=True)]
    path = tmp_path / "run.csv"
    path.write_text(f"t,{name},Torque_Mz\n" + "\n".join(rows))
    with pytest.raises(RecordError, match="is it not Torque_Mz") as refused:
        read_record(path, RecordSpec(name="run", path="run.csv"))
    assert said in str(refused.value)
    (entry,) = tomllib.loads(str(refused.value).partition("write ")[2])["channels"]
    read = read_record(path, RecordSpec(name="run", path="run.csv", channels=(ChannelSpec(**entry),)))
    assert np.array_equal(read.channel("torque").data[:], SINE)
