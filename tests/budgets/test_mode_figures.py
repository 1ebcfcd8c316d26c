"""The figures of one mode. Truth: the dict of its numbers, which the curves have to be."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from mechid.budgets.mode_figures import course, line_of_sight, over_rate


def curve(axes, label):
    (line,) = [line for line in axes.lines if line.get_label() == label]
    return line.get_xdata(), line.get_ydata()


def test_curves_over_the_rate_are_the_rms_along_each_line_of_sight(data):
    mode, figure = data["modes"][0], Figure()
    over_rate(data, mode, figure)
    over = mode["over_rate"]
    for k, axis in enumerate(data["line_of_sight"]):
        for label, key in ((f"{axis}, two-way, 95 % band", "rms_two_way_rad"), (f"{axis}, one-way", "rms_rad")):
            x, y = curve(figure.axes[0], label)
            np.testing.assert_allclose(x, mode["rates"])
            np.testing.assert_allclose(y, np.array(over[key])[:, k])


def test_the_cumulative_rms_ends_at_the_rms_of_all_lines(data):
    mode, figure = data["modes"][0], Figure()
    line_of_sight(data, mode, figure)
    for axis, rms in zip(data["line_of_sight"], mode["line_of_sight_rms_rad"], strict=True):
        x, y = curve(figure.axes[2], f"{axis}, lines, one-way")
        assert (y[0], x[0]) == (0.0, 0.0)
        assert y[-1] == pytest.approx(rms)


def test_a_profile_is_drawn_over_its_whole_time_with_its_rate(data):
    mode, figure = data["modes"][2], Figure()
    course(data, mode, figure)
    assert figure.axes[1].get_xlim() == (0.0, mode["duration_s"])
    for k, axis in enumerate(data["line_of_sight"]):
        _, y = curve(figure.axes[1], f"{axis}, one-way, 95 % band")
        np.testing.assert_allclose(y, mode["windowed"]["rms_rad"][k])
    (rate,) = figure.axes[2].lines
    np.testing.assert_allclose(rate.get_ydata(), mode["windowed"]["rate"])
