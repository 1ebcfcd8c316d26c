"""The figures of a design. Truth: the dict of its numbers, and the table of colours."""

import numpy as np
import pytest

from colours_drawn import wrong_colours
from mechid.designs.figures import ERRORS_BY_RECORD, RATES, design_figures, relative_errors


@pytest.fixture(scope="module")
def figures(data):
    return dict(design_figures(data))


def test_errors_after_the_last_record_are_those_of_all_chosen(data):
    """Truth: the median over the mechanisms, over the parameter's size; of a phase in rad."""
    last = relative_errors(data)[:, -1]
    for p, error in zip(data["parameters"], last, strict=True):
        scale = 180.0 / np.pi if p["unit"] == "deg" else abs(p["size"])
        expected = p["chosen_spread"][0]
        assert np.isnan(error) if expected is None else error == pytest.approx(expected / scale), p["name"]


def test_a_column_stands_for_no_record_and_each_one(data, figures):
    axes = figures[ERRORS_BY_RECORD].axes[0]
    names = [text.get_text() for text in axes.get_xticklabels()]
    assert names == ["no record", *(r["name"] for r in data["chosen"]["records"])]


def test_records_are_drawn_one_after_the_other_with_the_time_between_them(data, figures):
    axes, start = figures[RATES].axes[0], 0.0
    for line, record in zip(axes.lines, data["chosen"]["records"], strict=True):
        time, rate = line.get_data()
        assert (time[0], time[-1]) == pytest.approx((start, start + record["duration_s"]))
        assert max(rate) == max(r for _, r in record["rate_profile"])
        start += record["duration_s"] + data["limits"]["between_s"]


def test_many_records_have_no_name_or_number(data):
    """Truth: the limits of the module, from which on texts would lie over one another."""
    records = [{**data["chosen"]["records"][0], "name": f"full_{k}"} for k in range(60)]
    parameters = [{**p, "by_record": [p["by_record"][0]] * 61} for p in data["parameters"]]
    many = {**data, "parameters": parameters, "chosen": {**data["chosen"], "records": records}}
    drawn = dict(design_figures(many))
    assert not any(text.get_text() for text in drawn[ERRORS_BY_RECORD].axes[0].get_xticklabels())
    assert not drawn[ERRORS_BY_RECORD].axes[0].texts
    assert not drawn[RATES].axes[0].texts


def test_colours_mean_what_they_mean_elsewhere(figures):
    assert [line for figure in figures.values() for line in wrong_colours(figure)] == []
