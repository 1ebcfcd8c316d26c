"""Step loss as a design's tables and lines show it. Truth: by hand."""

import pytest

from mechid.designs.sentences import hole_lines
from mechid.designs.tables import limit_words

SEARCHED = [4.0, 4000.0]


def limit(ranges, holes=(), end=None):
    return {"ranges": ranges, "holes": list(holes), "limit": end, "searched": SEARCHED, "brought_from": 0.0}


@pytest.mark.parametrize(
    ("ranges", "words"),
    [
        ([[4.0, 354.4]], "354"),
        ([[4.0, 4000.0]], "> 4000"),
        ([[4.0, 118.2], [147.1, 1107.2]], "118, 147 to 1107"),
        ([[50.0, 90.0]], "50 to 90"),
        ([[4.0, 118.0], [147.0, 152.0], [157.0, 4000.0]], "118, 147 to 152, 157 to > 4000"),
        ([[4.0, 118.0], [147.0, 152.0], [157.0, 160.0], [163.0, 1107.0]], "118, 2 more, 163 to 1107"),
        ([], "none"),
    ],
)
def test_where_a_stepping_holds(ranges, words):
    assert limit_words(limit(ranges)) == words


def test_a_slow_start_above_a_hole_says_from_where():
    slow = {**limit([[417.0, 4000.0]]), "searched": [417.0, 4000.0], "brought_from": 417.0}
    assert limit_words(slow) == "417 to > 4000"


def test_holes_are_listed_at_the_values_believed():
    ranges, holes = [[4.0, 118.2], [147.1, 1107.2]], [[118.2, 147.1]]
    row = {
        "stepping": "full",
        "changed": "",
        "pull_in": limit(ranges, holes, 1107.2),
        "pull_out": limit([[417.0, 4000.0]]),
    }
    assert hole_lines({"step_loss": [row, {**row, "changed": "voltage"}]}) == [
        "full stepping, started at once: 118 to 147 steps/s; above 1107 steps/s it holds nowhere up to 4000"
    ]
