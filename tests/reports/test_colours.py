"""Colours mean the same everywhere. Truth: the one table of them, and the legends of what is drawn."""

import re
from dataclasses import replace
from importlib.resources import files
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from colours_drawn import wrong_colours
from mechid.analysis.look import look_at
from mechid.checks.figures import check_figures
from mechid.ink.drawings import draw
from mechid.ink.palette import MEANINGS, SERIES, colour_style
from mechid.ink.pens import Pens
from mechid.looks.figures import look_figures
from mechid.reports.illustration import Illustration

FOUR = ("measured", "modelled", "residual", "noise")
APART = 0.2
"""Least distance of two colours, each of red, green and blue 0 to 1."""
LITERAL = re.compile(r"[\"']#[0-9A-Fa-f]{6}[\"']")


def distance(one, other):
    return float(np.linalg.norm(np.subtract(to_rgb(one), to_rgb(other))))


@pytest.mark.parametrize("shade", ["paper", "light", "dark"])
def test_the_four_meanings_have_colours_that_nothing_else_has(shade):
    colours = {name: getattr(colour, shade) for name, colour in MEANINGS.items() if not name.endswith("-over")}
    for one, other in combinations(FOUR, 2):
        assert distance(colours[one], colours[other]) > APART
    for name in colours.keys() - set(FOUR):
        assert min(distance(colours[name], colours[one]) for one in FOUR) > 0.1


def test_series_have_colours_apart_from_the_four_meanings():
    assert len(set(SERIES)) == len(SERIES)
    for colour in SERIES:
        assert min(distance(colour, MEANINGS[name].paper) for name in FOUR) > APART


def test_no_colour_stands_anywhere_but_in_the_table():
    """Also not in a style sheet: a page's meanings are written by the table."""
    root = Path(str(files("mechid")))
    for path in root.rglob("*.py"):
        if path.name != "palette.py":
            assert LITERAL.findall(path.read_text(encoding="utf-8")) == [], path
    for path in (*root.rglob("*.css"), *root.rglob("*.html"), *root.rglob("*.js")):
        text = path.read_text(encoding="utf-8")
        assert [name for name in MEANINGS if f"--{name}:" in text] == [], path
    assert all(colour_style().count(f"--{name}:") == 4 for name in MEANINGS)


def test_style_sheets_use_a_meaning_for_nothing_else():
    """Truth: the classes that name it, in the keys of the explorer's figures."""
    for path in Path(str(files("mechid"))).rglob("*.[ch][st]*"):
        for line in path.read_text(encoding="utf-8").splitlines():
            for name in FOUR:
                assert line.count(f"var(--{name})") == line.count(f".line-{name}::before"), (path, line)


def test_the_figures_of_a_report(reported, tmp_path):
    asked = []

    class Asked(Pens):
        def draw(self, sheets, folder):
            asked.extend(sheets)
            return {}

    illustration = Illustration(reported.campaign, reported.fit, tmp_path, Asked())
    for record in reported.validation.values():
        illustration.begin(record)
    assert {sheet.drawing for sheet in asked} == {"torque", "spectrum", "residual", "spectrogram"}
    assert [line for sheet in asked for line in wrong_colours(draw(sheet))] == []


def test_the_figures_of_a_look_and_of_check(reported):
    look = look_at(reported.campaign.records[0].data)
    figures = [figure for _, figure in look_figures([look])]
    assert [line for figure in figures for line in wrong_colours(figure)] == []
    over_time = {record.name for record in reported.campaign.records}
    for figure in (figure for name, figure in check_figures(reported.campaign.records) if name in over_time):
        for axes in figure.axes[:-1]:
            assert axes.lines[0].get_color() == MEANINGS["measured"].paper


def test_what_python_plots(reported):
    record = reported.campaign.records[0].data
    for axes in (
        replace(reported.fit, campaign=reported.campaign).plot("full_46"),
        record.plot(),
    ):
        assert wrong_colours(axes.figure) == []
