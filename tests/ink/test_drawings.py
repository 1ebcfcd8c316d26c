"""Figures on paper from plain data. Truth: the arrays that were handed to them."""

import numpy as np

from mechid.ink.drawings import draw
from mechid.ink.sheet import Sheet

TIME = np.linspace(0.0, 1.0, 50)


def span(times, seed):
    rng = np.random.default_rng(seed)
    return tuple(np.vstack([times, rng.normal(size=times.size)]) for _ in range(3))


def test_measured_modelled_and_residual_are_drawn_as_they_are():
    whole, start = span(TIME, 1), span(TIME[:10], 2)
    figure = draw(Sheet("a_torque", 3.0, "torque", {"quantity": "torque", "whole": whole, "start": start}))
    drawn = {axes.get_label(): axes.lines for axes in figure.axes}
    for above, below, lines in (("whole", "residual", whole), ("start", "start residual", start)):
        shown = [*drawn[above], *drawn[below]]
        assert [line.get_label() for line in shown] == ["measured", "modelled", "residual"]
        for line, expected in zip(shown, lines, strict=True):
            np.testing.assert_array_equal(line.get_xydata().T, expected)
    assert figure.axes[0].get_ylabel() == "torque, N m"


def test_a_matrix_has_each_text_in_its_cell():
    values = np.array([[1.0, -0.9], [0.25, 1.0]])
    content = {
        "rows": ["a", "b"],
        "columns": ["c", "d"],
        "values": values,
        "texts": [["1.00", "-0.90"], ["0.25", "1.00"]],
        "label": "correlation",
        "signed": True,
    }
    figure = draw(Sheet("m", 3.0, "matrix", content))
    axes, bar = figure.axes
    np.testing.assert_array_equal(axes.images[0].get_array(), values)
    cells = {text.get_position(): (text.get_text(), text.get_color()) for text in axes.texts}
    assert cells == {
        (0, 0): ("1.00", "white"),
        (1, 0): ("-0.90", "white"),
        (0, 1): ("0.25", "black"),
        (1, 1): ("1.00", "white"),
    }
    assert [tick.get_text() for tick in axes.get_yticklabels()] == ["a", "b"]
    assert bar.get_ylabel() == "correlation"
