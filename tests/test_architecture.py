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
from mechid.display import DOCUMENTS

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = Path(mechid.__file__).parent
"""As it is imported: that of the checkout, or of a wheel that is tested."""
SOURCES = sorted(PACKAGE.rglob("*.py"))
LONGEST_FILE = 350
TESTS = ROOT / "tests"
LEAST_LINES = 150
"""A module of so many lines has a test file of its name."""
FOLDERS_WITHOUT_A_PACKAGE = {
    "measured": "campaigns on measured data by others: whole jobs, of no module by itself",
    "published": "mechanisms and data that others have published: whole jobs, of no module by itself",
    "kernel/golden": "texts that tests/kernel/test_source.py compares with",
}
WITHOUT_A_TEST_FILE = {"identification/conclude.py"}
"""Modules whose tests do not lie in a file of their name yet. It only gets shorter: nothing is added here."""
WITHOUT_A_FUNCTION = {"validations/run.py"}
"""Functions of capabilities that stand in a lower layer, which needs them too."""
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


def test_a_file_holds_one_idea_and_is_named_for_it() -> None:
    """Truth: the house's limits on a file; the formatter alone sets it."""
    names = {path: path.parent.name if path.stem == "__init__" else path.stem for path in SOURCES}
    texts = {path: path.read_text(encoding="utf-8") for path in SOURCES}
    assert not [path for path, name in names.items() if name.strip("_") in NAMES_THAT_SAY_NOTHING]
    assert not [path for path, text in texts.items() if len(text.splitlines()) > LONGEST_FILE]
    assert not [path for path, text in texts.items() if re.search(r"# fmt: *(skip|off)", text)]


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


def test_a_capability_has_its_function_and_its_document_in_its_folder() -> None:
    """Truth: the folders; where a command's function stands, and what is shown of its result, follows from its name."""
    folders = {module.split(".")[1] for module in DOCUMENTS.values()}
    asked = {f"{folder}/{file}.py" for folder in folders for file in ("run", "document")}
    assert {file for file in asked if not (PACKAGE / file).is_file()} == WITHOUT_A_FUNCTION


def test_test_folders_mirror_the_packages() -> None:
    """Truth: the folders of the package; where a test goes follows from the module that it tests."""
    folders = {path.parent.relative_to(TESTS).as_posix() for path in TESTS.rglob("*") if path.suffix in (".py", ".txt")}
    strange = {name for name in folders - FOLDERS_WITHOUT_A_PACKAGE.keys() if not (PACKAGE / name).is_dir()}
    assert not strange
    assert folders >= FOLDERS_WITHOUT_A_PACKAGE.keys()


def test_a_module_of_some_size_has_a_test_file_of_its_name() -> None:
    """Truth: the files. Settings are values alone, which `test_a_setting_is_frozen_and_says_what_it_is` looks at."""
    assert _without_a_test_file() - WITHOUT_A_TEST_FILE == set()


def test_a_module_that_has_got_its_test_file_is_no_longer_listed() -> None:
    assert WITHOUT_A_TEST_FILE - _without_a_test_file() == set()


def _without_a_test_file() -> set[str]:
    names = [path.relative_to(PACKAGE) for path in SOURCES if _lines(path) >= LEAST_LINES]
    tested = {name for name in names if (TESTS / name.parent / f"test_{name.stem.strip('_')}.py").is_file()}
    return {name.as_posix() for name in names if name not in tested and name.stem not in ("__init__", "settings")}


def _lines(path: Path) -> int:
    return len(path.read_text(encoding="utf-8").splitlines())


@pytest.mark.parametrize(
    "path",
    [path for path in SOURCES if path.stem == "settings"],
    ids=lambda path: path.relative_to(PACKAGE).as_posix(),
)
def test_a_setting_is_frozen_and_says_what_it_is(path: Path) -> None:
    """Truth: the text of the module; behind each field stands a sentence on it."""
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.ClassDef):
            assert any("frozen=True" in ast.unparse(decorator) for decorator in node.decorator_list), node.name
            for field, behind in zip(node.body, [*node.body[1:], None], strict=True):
                if isinstance(field, ast.AnnAssign):
                    said = isinstance(behind, ast.Expr) and isinstance(behind.value, ast.Constant)
                    assert said, f"{node.name}.{ast.unparse(field.target)}"


def _is_there(module: str, name: str) -> bool:
    return find_spec(module) is not None and (
        hasattr(import_module(module), name) or find_spec(f"{module}.{name}") is not None
    )
