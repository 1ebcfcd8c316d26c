"""House rules of language: heads of modules, names of functions, comments. Truth: CONTRIBUTING.md, and the sources."""

import ast
import re
from pathlib import Path

import pytest

SOURCES = sorted(
    path for path in (Path(__file__).parents[1] / "src" / "mechid").rglob("*.py") if path.parent.name != "loop"
)
"""Without the text of the kernels' time loop, which is stored word by word (tests/kernel/golden)."""
MOST_WHAT = 500
"""Times that "what" may stand in all docstrings: mostly a noun of the field says more."""
LEAST_COMMENTS = 15.0
"""Own-line comments per 1000 lines of code."""
NO_SUBJECT = re.compile(r"(What|Whether|Who|How|Where|When)\b")
PARTICIPLE = re.compile(r"_?[a-z]+(ed|ing|ly)")
IRREGULAR = frozenset(
    re.findall(
        r"\w+",
        """away begun beside between bound brought built drawn driven far found given grown held kept known left louder
        made own seen sent shown taken told worth written""",
    )
)
NOUNS = frozenset(
    re.findall(
        r"\w+",
        """apply assembly bearing bound called comply coupling damping detrended embed family feed forcing heading
        housing imply listing loading mapping meaning mounting multiply need nothing reading reply ring seed settings
        spacing speed spring stepping string supply timing tracking weighting wiring""",
    )
)
"""Words of the field, or of Python, that look like a bare participle and are a noun or a verb."""


@pytest.fixture(scope="module")
def trees():
    """Return the syntax tree of each module, by its path."""
    return {path: ast.parse(path.read_text(encoding="utf-8")) for path in SOURCES}


def test_the_head_of_a_module_names_a_thing(trees):
    assert not [path for path, tree in trees.items() if NO_SUBJECT.match(ast.get_docstring(tree) or "")]


def functions(trees):
    """Yield all functions, each with its file."""
    for path, tree in trees.items():
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef):
                yield path, node


def test_no_function_is_called_by_a_bare_participle_or_adverb(trees):
    """A property is a value, and may be called by an adjective."""
    found = []
    for path, node in functions(trees):
        word = node.name.lstrip("_")
        is_value = any(isinstance(d, ast.Name) and "property" in d.id for d in node.decorator_list)
        is_bare = bool(PARTICIPLE.fullmatch(word)) or word in IRREGULAR
        if is_bare and word not in NOUNS and not is_value:
            found.append(f"{path.name}: {node.name}")
    assert not found


def test_docstrings_name_things(trees):
    kinds = (ast.Module, ast.ClassDef, ast.FunctionDef)
    docstrings = [ast.get_docstring(n) or "" for t in trees.values() for n in ast.walk(t) if isinstance(n, kinds)]
    assert sum(len(re.findall(r"\bwhat\b", text, re.IGNORECASE)) for text in docstrings) <= MOST_WHAT


def test_tricks_orders_and_thresholds_have_their_reason_beside_them():
    lines = [line.strip() for path in SOURCES for line in path.read_text(encoding="utf-8").splitlines()]
    comments = sum(line.startswith("#") for line in lines)
    code = sum(bool(line) and not line.startswith("#") for line in lines)
    assert 1000.0 * comments / code >= LEAST_COMMENTS
