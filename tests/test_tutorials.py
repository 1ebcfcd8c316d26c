"""The tutorials and the gallery run as they stand. Truth: what their cells claim of the synthetic bench."""

import os
import re
import runpy
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
TUTORIALS = sorted((ROOT / "docs" / "tutorials").glob("*.md"))
SCRIPTS = sorted((ROOT / "examples" / "gallery").glob("*.py"))
BLOCK_SCRIPTS = sorted((ROOT / "examples" / "blocks").glob("*.py"))
CELL = re.compile(r"^```\{code-cell\}[^\n]*\n(?::[^\n]*\n)*(.*?)^```$", re.MULTILINE | re.DOTALL)
COMMAND = re.compile(r"^!(.*)$", re.MULTILINE)
MOST_LINES = 20


def cells(page):
    """Return the Python cells of a page; a line of the shell becomes a call."""
    return [COMMAND.sub(lambda line: f"shell({line[1]!r})", cell) for cell in CELL.findall(page.read_text("utf-8"))]


def shell(command):
    """Run a line of the shell as a notebook does, with this mechid; it has to succeed."""
    program = f"{shlex.quote(sys.executable)} -m mechid "
    subprocess.run(re.sub(r"\bmechid (?=[a-z])", lambda _: program, command), shell=True, check=True)


def run(page):
    """Run the cells of a page one after another in one namespace."""
    import matplotlib.pyplot as plt

    names = {"__name__": "__main__", "shell": shell, "display": print}
    for number, cell in enumerate(cells(page), 1):
        exec(compile(cell, f"{page.name}, cell {number}", "exec"), names)
        plt.close("all")


@pytest.mark.parametrize("page", TUTORIALS, ids=lambda page: page.stem)
def test_a_tutorial_is_text_that_a_notebook_program_opens(page):
    text = page.read_text("utf-8")
    assert page.stem == "index" or (text.startswith("---\nfile_format: mystnb\n") and cells(page))
    for number, cell in enumerate(cells(page), 1):
        compile(cell, f"{page.name}, cell {number}", "exec")


@pytest.mark.slow
@pytest.mark.parametrize("page", [page for page in TUTORIALS if page.stem != "index"], ids=lambda page: page.stem)
def test_a_tutorial_runs(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "agg")
    run(page)


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_a_script_of_the_gallery_is_short_and_shown(script):
    assert len(script.read_text("utf-8").splitlines()) <= MOST_LINES
    page = (ROOT / "docs" / "gallery.md").read_text("utf-8")
    assert f"](../examples/gallery/{script.name})" in page
    assert f"](images/gallery/{script.stem}.png)" in page


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    """Return a folder in which `mechid demo` was run."""
    folder = tmp_path_factory.mktemp("gallery")
    subprocess.run([sys.executable, "-m", "mechid", "demo"], cwd=folder, check=True, capture_output=True)
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_a_script_of_the_gallery_draws(script, demo, monkeypatch):
    monkeypatch.chdir(demo)
    monkeypatch.setenv("MPLBACKEND", "agg")
    runpy.run_path(os.fspath(script), run_name="__main__")
    assert (demo / f"{script.stem}.png").stat().st_size > 10_000


@pytest.mark.parametrize("script", BLOCK_SCRIPTS, ids=lambda script: script.stem)
def test_a_picture_of_a_block_is_on_one_page_with_its_script(script):
    pages = [page.read_text("utf-8") for page in (ROOT / "docs" / "blocks").glob("*.md")]
    (page,) = [page for page in pages if f"](../../examples/blocks/{script.name})" in page]
    assert f"](../images/blocks/{script.stem}.png)" in page


@pytest.mark.slow
@pytest.mark.parametrize("script", BLOCK_SCRIPTS, ids=lambda script: script.stem)
def test_a_script_of_a_block_draws(script, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "agg")
    runpy.run_path(os.fspath(script), run_name="__main__")
    assert (tmp_path / f"{script.stem}.png").stat().st_size > 10_000
