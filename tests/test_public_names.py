"""The public names. Truth: the table of docs/python.md, the modules themselves, what a docstring of the house has."""

import inspect
import re
import typing
from pathlib import Path

import pytest

import mechid
from mechid.cli.app import VERBS

ROOT = Path(__file__).parents[1]
LISTED = re.findall(r"^\| `(\w+)` \|", (ROOT / "docs" / "python.md").read_text(encoding="utf-8"), re.MULTILINE)
NAMES = sorted(set(mechid.__all__) - {"__version__"})
FUNCTIONS = [name for name in NAMES if inspect.isfunction(getattr(mechid, name))]
CLASSES = [name for name in NAMES if inspect.isclass(getattr(mechid, name))]
COMMANDS = (
    "look",
    "check",
    "emission",
    "simulate",
    "identify",
    "diagnose",
    "validate",
    "compare",
    "profile",
    "bootstrap",
    "design",
    "budget",
    "quiet",
    "export",
    "report",
    "fleet",
    "demo",
    "explore",
)
OTHERWISE_CALLED = {"new": {"new_campaign"}, "kernel": {"equations", "kernel_source"}}
"""Commands whose functions have longer names: beside functions called "make_", "new" would say nothing, and
`mechid.kernel` is a folder of modules."""
REFUSES_NOTHING = ("equations", "validate")
"""A simulation that fails gives NaN there; a mechanism that could be made has equations."""


def test_the_page_lists_each_public_name_once():
    assert sorted(LISTED) == sorted(mechid.__all__)


def test_what_is_public_is_what_the_modules_of_the_names_give():
    assert set(mechid._HOMES) == set(NAMES)
    assert set(NAMES) <= set(dir(mechid))


@pytest.mark.parametrize("name", COMMANDS)
def test_each_command_is_a_function(name):
    assert name in FUNCTIONS


def test_no_command_is_without_a_function():
    """Truth: the verbs of the command line."""
    verbs = {verb.__name__ for verb in VERBS}
    assert verbs == {*COMMANDS, *OTHERWISE_CALLED} - {"validate"}
    assert set().union(*OTHERWISE_CALLED.values()) <= set(FUNCTIONS)


@pytest.mark.parametrize("name", NAMES)
def test_each_name_has_a_docstring(name):
    assert len(inspect.getdoc(getattr(mechid, name)).split()) >= 3


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_function_says_what_it_takes_raises_and_how_it_is_called(name):
    function = getattr(mechid, name)
    text = inspect.getdoc(function)
    for argument in inspect.signature(function).parameters:
        assert re.search(rf"^\*?[\w, *]*\b{argument}\b[\w, ]* : |^[\w, ]*\b{argument}\b[\w, ]*$", text, re.MULTILINE), (
            argument
        )
    assert "Raises\n------" in text or name in REFUSES_NOTHING
    assert "Examples\n--------" in text


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_function_is_typed(name):
    function = getattr(mechid, name)
    annotated = function.__annotations__
    assert set(annotated) == {*inspect.signature(function).parameters, "return"}


@pytest.mark.parametrize("name", CLASSES)
def test_what_a_class_offers_has_a_docstring(name):
    offered = getattr(mechid, name)
    own = [key for base in offered.__mro__ if base.__module__.startswith("mechid") for key in vars(base)]
    for key in (key for key in own if not key.startswith("_")):
        member = inspect.getattr_static(offered, key)
        if inspect.isfunction(member) or isinstance(member, property | classmethod):
            assert inspect.getdoc(getattr(offered, key) if isinstance(member, classmethod) else member), f"{name}.{key}"


def test_importing_mechid_loads_nothing_heavy():
    import subprocess
    import sys

    heavy = (
        "import mechid, sys; print([m for m in ('numpy', 'scipy', 'sympy', 'numba', 'matplotlib') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", heavy], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_type_checkers_see_the_same_names():
    """Truth: the text of mechid itself, where the names stand once for tools and once for the interpreter."""
    text = inspect.getsource(mechid)
    block = text[text.index("if TYPE_CHECKING:\n    from") : text.index("__version__ =")]
    seen = {name.strip() for line in re.findall(r"import (.+)$", block, re.MULTILINE) for name in line.split(",")}
    assert seen == set(NAMES)
    assert typing.TYPE_CHECKING is False
