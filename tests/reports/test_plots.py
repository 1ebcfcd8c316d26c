"""The interactive figures. Truth: Bokeh's own document of each, read back; what a page's script looks for by name."""

import json

import pytest
from bokeh.models import Legend, Range1d

from mechid.reports.plots import add_curve, add_legend, empty_plot, plot_items, stack_axes

KINDS = {
    "torque": {"measured", "modelled", "residual"},
    "spectrum": {"measured", "modelled", "residual"},
    "density": {"residual", "noise"},
}


@pytest.fixture(scope="module")
def items():
    return plot_items()


def objects(node):
    """Yield every object of a document by its attributes, wherever it stands."""
    if isinstance(node, dict):
        if "attributes" in node:
            yield node["name"], node["attributes"]
        for value in node.values():
            yield from objects(value)
    elif isinstance(node, list):
        for value in node:
            yield from objects(value)


@pytest.mark.parametrize("kind", KINDS)
def test_the_script_finds_each_curve_by_its_name_and_it_has_no_data(items, kind):
    found = list(objects(json.loads(json.dumps(items[kind]))))
    named = {attributes.get("name") for model, attributes in found if model == "GlyphRenderer"}
    assert named >= KINDS[kind]
    for model, attributes in found:
        if model == "ColumnDataSource":
            assert not any(len(column) for column in dict(attributes["data"].get("entries", [])).values())


def test_every_kind_is_a_document_of_its_own_in_json(items):
    assert set(items) == {"torque", "spectrum", "density", "correlation", "spectrogram"}
    assert all(set(item) >= {"doc", "root_id"} for item in items.values())
    assert all(item["doc"]["roots"][0]["id"] == item["root_id"] for item in items.values())


def test_plots_on_one_axis_move_together():
    """Truth: the range that both were given; a legend names its curves, in other words where these are given."""
    time = Range1d(start=0.0, end=1.0, name="time")
    above, below = (empty_plot("time, s", label, x_range=time) for label in ("torque, N m", "residual, N m"))
    curve = add_curve(above, "measured")
    add_legend(above, [curve], {"measured": "as recorded"})
    assert above.x_range is below.x_range is time
    (legend,) = above.select(Legend)
    assert [(item.label.value, item.renderers) for item in legend.items] == [("as recorded", [curve])]
    assert above.yaxis.axis_label == "torque, N m"
    assert set(stack_axes([above, below]).select({"type": type(above)})) == {above, below}
