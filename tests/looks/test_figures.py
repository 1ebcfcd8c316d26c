"""The figures of a look. Truth: the lines that were put into the record, and the record itself."""

from pathlib import Path

import numpy as np
import pytest

from look_records import LINES, RATE_HZ, STEPS, torque
from mechid.analysis.look import look_at
from mechid.looks.figures import axis_label, look_figures, spectrum_groups
from mechid.records import Channel, Record


@pytest.fixture(scope="module")
def look():
    channel = Channel(quantity="torque", unit="N*m", data=torque(), role="output", column="torque_Nm")
    made = Record(
        name="two", path=Path("two.csv"), digest="", time_start_s=0.0, sample_rate_hz=RATE_HZ, channels=(channel,)
    )
    return look_at(made)


def test_the_spectrum_has_each_line_at_its_amplitude(look):
    """Truth: the amplitudes; a line that stands on a frequency of the transform keeps its own, but for the noise."""
    frequency, amplitudes, level = spectrum_groups(look.channels[0])
    for order, amplitude in LINES.items():
        near = np.abs(frequency - order * STEPS) < 1.0
        assert amplitudes[near].max() == pytest.approx(amplitude, rel=0.02)
        assert level[near].max() < 0.1 * amplitude


def test_each_kind_of_figure_is_there_once_with_the_unit_on_its_axis(look):
    """Truth: the kinds, of which the one over the rate needs a command whose rate varies."""
    figures = dict(look_figures([look]))
    assert [name.rpartition("_")[2] for name in figures] == ["time", "spectrum", "waterfall", "bands"]
    assert axis_label(look.channels[0]) == "torque, N m"
    assert next(iter(figures.values())).axes[0].get_ylabel() == "torque, N m"
    assert [name for name, _ in look_figures([look], ("spectrum",))] == [n for n in figures if n.endswith("spectrum")]
