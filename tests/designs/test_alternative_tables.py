"""What is said of rival effects: each of the answers that a design can come to."""

import pytest

from mechid.designs.alternative_tables import pair_rows, rival_lines
from mechid.designs.separation import CLEAR

NAMES = ["stepper.detent:7.2deg", "stepper.phase_offset"]
CANDIDATES = [
    {"name": "full_46", "objection": "", "tells_apart": {NAMES[0]: 40.0}},
    {
        "name": "full_sweep",
        "objection": "near a stick/slip threshold in 30 % of draws",
        "tells_apart": {NAMES[0]: 900.0},
    },
    {"name": "full_600", "objection": "loses steps at the values believed", "tells_apart": {NAMES[0]: None}},
]


def data(candidates=CANDIDATES, **changes):
    group = {
        "names": NAMES,
        "now": {NAMES[0]: 2.0, NAMES[1]: 0.0},
        "told_already": False,
        "needed": CLEAR,
        "clear": True,
        "expected": 180.0,
        "records": ["full_60"],
        "seconds": 11.0,
        "pairs": [
            {
                "if_true": a,
                "against": b,
                "now": 2.0,
                "first_order": 181.5,
                "expected": 180.0,
                "record": "full_60",
                "differ_rms_Nm": 0.000244,
                "differ_most_hz": 57.99,
            }
            for a, b in (NAMES, NAMES[::-1])
        ],
        "farthest": {"records": ["full_60"], "expected": 181.0},
    }
    return {"rivals": [{**group, **changes}], "candidates": candidates, "limits": {"total_s": 120.0}}


NONE = {"records": [], "clear": False, "pairs": []}


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        (
            {},
            "drive full_60 (11 s with what is between records). Fitted to all records then, the wrong one has a "
            "chi-square larger by 180 or more, where 61 are enough",
        ),
        ({"clear": False, "expected": 20.0}, "larger by 20 only, and 61 are needed"),
        ({"told_already": True, "now": {NAMES[0]: 11000.0, NAMES[1]: 0.0}}, "stepper.phase_offset explains them best"),
        ({**NONE, "farthest": {"records": ["full_46"], "expected": 40.0}}, "in 120 s: full_46 would come to 40"),
        ({**NONE, "farthest": {"records": [], "expected": 2.0}}, "no record fits into the test time"),
        ({**NONE, "farthest": {"records": ["full_46"], "expected": 3e-5}}, "both make the same torque"),
        (
            {**NONE, "farthest": {"records": ["full_46"], "expected": 40.0}},
            "full_sweep would come to 900 but is left out: near a stick/slip threshold in 30 % of draws",
        ),
    ],
)
def test_each_answer_in_words(changes, said):
    """Truth: the answer that the numbers of the entry stand for."""
    (line,) = rival_lines(data(**changes))
    assert line.startswith("stepper.detent:7.2deg or stepper.phase_offset: ")
    assert said in line


def test_the_table_has_each_rival_once_for_the_truth():
    """Truth: the numbers of the entry; mN m for N m."""
    first, second = pair_rows(data())
    assert (first["if_true"], second["if_true"]) == tuple(NAMES)
    assert first["differ"] == "0.24"
    assert first["expected"] == "180"


def test_nothing_is_said_where_no_diagnosis_was_given():
    assert rival_lines({"rivals": None}) == []
