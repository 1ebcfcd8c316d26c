"""What surrounds the package says the same as pyproject.toml. Truth: pyproject.toml and the version in the package."""

import re
import tomllib
from pathlib import Path

import pytest
import yaml

import mechid

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
RECIPE = yaml.safe_load((ROOT / "conda" / "recipe.yaml").read_text(encoding="utf-8"))
CITATION = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
AT_CONDA = {"matplotlib": "matplotlib-base"}
"""What conda calls otherwise: its `matplotlib` brings a graphical toolkit that mechid has no use for."""


def as_at_conda(requirement):
    """Return a requirement as a conda recipe writes it; one package is for all systems, so that markers fall away."""
    name, version = re.fullmatch(r"([A-Za-z0-9_.-]+)([^;]*).*", requirement).groups()
    return f"{AT_CONDA.get(name, name)} {version}"


def test_the_conda_recipe_asks_for_the_same_packages():
    wanted = [f"python {PROJECT['requires-python']}", *map(as_at_conda, PROJECT["dependencies"])]
    assert RECIPE["requirements"]["run"] == wanted


def test_the_conda_recipe_builds_with_the_same_tool():
    needed = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["build-system"]["requires"]
    assert set(map(as_at_conda, needed)) <= set(RECIPE["requirements"]["host"])


def test_the_conda_recipe_has_the_same_command():
    scripts = [f"{name} = {place}" for name, place in PROJECT["scripts"].items()]
    assert RECIPE["build"]["python"]["entry_points"] == scripts


def test_one_version_and_one_licence():
    assert RECIPE["context"]["version"] == CITATION["version"] == mechid.__version__
    assert RECIPE["about"]["license"] == CITATION["license"] == PROJECT["license"]


def test_the_citation_names_the_paper():
    (paper,) = CITATION["references"]
    assert [author["family-names"] for author in paper["authors"]] == ["Kornienko", "Wuseni", "Specht"]
    assert (paper["year"], paper["doi"]) == (2013, "10.3182/20130902-5-DE-2040.00057")
    assert PROJECT["urls"]["The paper it follows"] == f"https://doi.org/{paper['doi']}"


def test_the_source_archive_has_every_page_and_what_the_tests_read():
    """Truth: the pages in the root, and the folders that tests open. README and LICENSE go along anyway."""
    build = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["hatch"]["build"]
    pages = {path.name for path in ROOT.iterdir() if path.suffix in {".md", ".cff"}} - {"README.md"}
    assert {*build["targets"]["sdist"]["include"]} >= {*pages, "conda", "tests", "examples", "benchmarks", "Makefile"}


@pytest.mark.parametrize("extra", sorted(PROJECT["optional-dependencies"]))
def test_every_extra_is_documented_and_pinned(extra):
    """Truth: the table in docs/commands.md, and the list from which `make lock` makes the pins."""
    assert f"| `{extra}` |" in (ROOT / "docs" / "commands.md").read_text(encoding="utf-8")
    recipe = (ROOT / "Makefile").read_text(encoding="utf-8").split("\nlock:")[1]
    assert extra in re.search(r"install -e '\.\[([a-z,]+)\]'", recipe)[1].split(",")
    pins = {re.sub(r"[-_.]+", "-", name).lower() for name in re.findall(r"^([^=#\s]+)==", pinned(), re.MULTILINE)}
    for requirement in PROJECT["optional-dependencies"][extra]:
        name = re.match(r"[A-Za-z0-9_.-]+", requirement)[0]
        assert re.sub(r"[-_.]+", "-", name).lower() in pins, requirement


def pinned():
    return (ROOT / "constraints.txt").read_text(encoding="utf-8")
