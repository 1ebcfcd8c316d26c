"""Whether a figure's colours mean what the one table of them says: measured, modelled, residual, noise."""

from matplotlib.collections import Collection
from matplotlib.colors import to_hex
from matplotlib.lines import Line2D

from mechid.ink.palette import MEASURED, MODELLED, NOISE, RESIDUAL

SAID = {
    MEASURED: ("measured", "amplitude"),
    MODELLED: ("modelled", "torque lines", "largest line", "95 % interval", "dynamic stiffness"),
    RESIDUAL: ("residual",),
    NOISE: ("noise", "level around"),
}
"""Words of a legend, one of which stands where a colour does; what the budget draws of torque alone is modelled."""
MEANS = (("measured", MEASURED), ("modelled", MODELLED), ("residual", RESIDUAL), ("noise", NOISE))


def wrong_colours(figure, *, other=()):
    """Return what of a figure is drawn in a colour of another meaning, each with its label.

    `other` are labels of something else that a word of `MEANS` happens to stand in.
    """
    wrong = []
    for axes in figure.axes:
        for artist in (*axes.lines, *axes.collections, *axes.patches):
            label, colours = str(artist.get_label()), colours_of(artist)
            if not label or label.startswith("_"):
                continue
            wrong += [
                f"{label}: {colour}"
                for colour, words in SAID.items()
                if colour.lower() in colours and not any(word in label for word in words)
            ]
            expected = [colour for word, colour in MEANS if label.startswith(word)]
            if expected and label not in other and expected[0].lower() not in colours:
                wrong.append(f"{label}: {sorted(colours)}")
    return wrong


def colours_of(artist):
    """Return the colours of an artist as hexadecimal texts."""
    if isinstance(artist, Line2D):
        return {to_hex(artist.get_color())}
    if isinstance(artist, Collection):
        return {to_hex(one) for one in (*artist.get_edgecolor(), *artist.get_facecolor())}
    return {to_hex(artist.get_facecolor()), to_hex(artist.get_edgecolor())}
