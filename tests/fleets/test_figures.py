"""The figures of a fleet. Truth: the one table of colours, and the labels of the campaigns."""

from matplotlib.collections import Collection
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from colours_drawn import SAID, colours_of, wrong_colours
from mechid.fleets.figures import fleet_figures
from mechid.fleets.texts import fleet_texts


def test_colours_mean_what_they_mean_elsewhere(data):
    """Truth: the one table of colours; what a fleet draws is neither measured nor modelled, residual or noise."""
    for _, figure in fleet_figures(fleet_texts(data)):
        assert wrong_colours(figure) == []
        drawn = {colour for axes in figure.axes for artist in axes.get_children() for colour in colours_if_any(artist)}
        assert drawn.isdisjoint(colour.lower() for colour in SAID)


def colours_if_any(artist):
    return colours_of(artist) if isinstance(artist, Line2D | Collection | Patch) else set()


def test_no_name_is_longer_than_there_is_room_below_a_panel(data):
    """Truth: the height of the figure, below whose edge a label of a user's file ran."""
    figure = dict(fleet_figures(fleet_texts(data)))["fleet_parameters"]
    figure.canvas.draw()
    boxes = [label.get_window_extent() for axes in figure.axes for label in axes.get_xticklabels()]
    assert min(box.y0 for box in boxes) >= 0.0
