"""The glossary and the words of the program. Truth: the enumerations and the texts that the program shows."""

import ast
import re
from pathlib import Path

import mechid
from mechid.identification.result.grade import CAUSE_WORDS, GRADE_WORDS, Cause, FitOutcome, Grade
from mechid.parameter import Status

ROOT = Path(mechid.__file__).parent
PAGE = (Path(__file__).resolve().parents[1] / "docs" / "glossary.md").read_text(encoding="utf-8")
ROWS = [line.strip("|").split(" | ") for line in PAGE.splitlines() if line.startswith("| ") and "---" not in line]
TERMS = {row[0].strip(): row for row in ROWS}
RETIRED = re.compile(
    r"hangs by|\bcliff\b|in the small|derivatives say|noise released|not told|local only|grazes?\b", re.I
)
"""What pages and messages said before there was one set of words."""
STAGE_NAMES = (
    "multi-start",
    "gated growth",
    "records compared",
    "joint fit",
    "noise re-estimated",
    "whitened again",
    "spikes rejected",
    "growth again",
    "along a threshold",
    "from a lower draw",
)


def texts(path):
    """Yield the texts of a module that a user may read: no docstrings, and none that is a single word, a code."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    docs = {id(n.value) for n in ast.walk(tree) if isinstance(n, ast.Expr) and isinstance(n.value, ast.Constant)}
    for n in ast.walk(tree):
        if isinstance(n, ast.Constant) and isinstance(n.value, str) and id(n) not in docs and " " in n.value.strip():
            yield n.value


def test_every_grade_stands_in_the_glossary_as_the_program_says_it():
    for grade in Grade:
        term = "failed" if grade is Grade.FAILED else f"grade {grade}"
        meaning = re.sub(r"^(Grade .|Failed): ", "", GRADE_WORDS[grade]).rstrip(".")
        assert TERMS[term][1] == meaning


def test_every_cause_is_a_term_with_its_code():
    for cause in Cause:
        assert f"`{cause}`" in TERMS[CAUSE_WORDS[cause]][2]


def test_every_status_is_a_term():
    assert {status.replace("_", " ") for status in Status} <= set(TERMS)


def test_outcomes_whose_code_is_not_plain_stand_beside_their_term():
    assert f"outcome `{FitOutcome.CLIFF.code}`" in TERMS["stick/slip threshold"][2]
    assert f"outcome `{FitOutcome.HORIZON.code}`" in TERMS["followed in part"][2]


def test_stages_have_the_names_of_the_glossary():
    shown = {text for path in (ROOT / "identification").rglob("*.py") for text in texts(path)} | {"multi-start"}
    for name in STAGE_NAMES:
        assert name in TERMS
        assert name in shown, name


def test_no_text_uses_a_retired_word():
    found = [f"{path.name}: {text}" for path in ROOT.rglob("*.py") for text in texts(path) if RETIRED.search(text)]
    pages = [path for path in ROOT.rglob("*.html") if RETIRED.search(path.read_text(encoding="utf-8"))]
    assert not found + pages
