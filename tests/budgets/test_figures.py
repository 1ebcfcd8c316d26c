"""The figures of a budget. Truth: the dict of its numbers, the table of colours, places as Matplotlib draws them."""

import pytest

from colours_drawn import wrong_colours
from mechid.budgets.figures import budget_figures


def test_the_figures_bar_is_the_level_that_decides(data):
    """Truth: the dict's own numbers, as shares of the limit; the margin that does not decide is marked beside."""
    (axes,) = dict(budget_figures(data))["budget_requirements"].axes
    widths = [patch.get_width() for patch in axes.patches]
    assert widths == pytest.approx([r["decided"]["level_rad"] / r["limit_rad"] for r in data["requirements"]])
    marks = {line.get_label(): line for line in axes.lines}
    row = data["requirements"][0]
    assert marks["one-way, does not decide"].get_xdata()[0] == pytest.approx(row["level_rad"] / row["limit_rad"])


@pytest.mark.slow
def test_no_legend_lies_over_curves(data):
    """Truth: the places of legends and axes as Matplotlib draws them."""
    for name, figure in dict(budget_figures(data)).items():
        figure.draw_without_rendering()
        axes = [a.get_window_extent() for a in figure.axes]
        legends = [*figure.legends, *(a.get_legend() for a in figure.axes if a.get_legend())]
        boxes = [(b.x0 + 1, b.y0 + 1, b.x1 - 1, b.y1 - 1) for b in (legend.get_window_extent() for legend in legends)]
        over = [1 for x0, y0, x1, y1 in boxes for a in axes if x0 < a.x1 and x1 > a.x0 and y0 < a.y1 and y1 > a.y0]
        assert not over, name


def test_colours_mean_what_they_mean_elsewhere(data):
    """Truth: the one table of colours."""
    figures = dict(budget_figures(data))
    assert [line for figure in figures.values() for line in wrong_colours(figure)] == []


def test_only_shares_that_can_be_seen_are_named(data):
    """Truth: the shares themselves."""
    figure = dict(budget_figures(data))["budget_shares"]
    named = {text.get_text() for text in figure.legends[0].get_texts()} - {"all others"}
    largest = {n: max(r["variance_shares"].get(n, 0.0) for r in data["requirements"]) for n in named}
    assert named
    assert min(largest.values()) >= 0.01
