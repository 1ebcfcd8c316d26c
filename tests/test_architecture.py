"""The house rules that a program can check: the order of the layers, the size and the names of files."""

import ast
import re
import subprocess
import sys
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import pytest

import mechid

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = Path(mechid.__file__).parent
"""As it is imported: that of the checkout, or of a wheel that is tested."""
SOURCES = sorted(PACKAGE.rglob("*.py"))
LONGEST_FILE = 350
NAMES_THAT_SAY_NOTHING = {"base", "common", "helper", "helpers", "misc", "tools", "util", "utils"}


def test_a_layer_imports_only_lower_ones() -> None:
    """Truth: the contracts in pyproject.toml, which are the layers of docs/architecture.md.

    In a process of its own: it switches off every logger that it finds, which later tests listen to.
    """
    command = [Path(sys.executable).with_name("lint-imports"), "--config", ROOT / "pyproject.toml", "--no-cache"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_sources_are_found() -> None:
    assert PACKAGE / "plant" / "friction.py" in SOURCES


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: path.relative_to(PACKAGE).as_posix())
def test_a_file_holds_one_idea_and_is_named_for_it(path: Path) -> None:
    """Truth: the house's limits on a file; the formatter alone sets it."""
    name, text = path.parent.name if path.stem == "__init__" else path.stem, path.read_text(encoding="utf-8")
    assert name.strip("_") not in NAMES_THAT_SAY_NOTHING
    assert len(text.splitlines()) <= LONGEST_FILE
    assert not re.search(r"# fmt: *(skip|off)", text)


@pytest.mark.parametrize("folder", ["benchmarks", "examples", "fuzz"])
def test_what_scripts_import_of_mechid_is_there(folder: str) -> None:
    """Truth: the modules themselves; no other test imports these scripts, so that a moved name would not be seen."""
    scripts = sorted((ROOT / folder).rglob("*.py"))
    asked = {
        (node.module or "", alias.name, path.name)
        for path in scripts
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] == "mechid"
        for alias in node.names
    }
    assert asked
    lost = [one for one in sorted(asked) if not _is_there(*one[:2])]
    assert not lost


def _is_there(module: str, name: str) -> bool:
    return find_spec(module) is not None and (
        hasattr(import_module(module), name) or find_spec(f"{module}.{name}") is not None
    )
