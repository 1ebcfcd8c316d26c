"""``mechid export --to c`` and ``--to fmu`` from a shell: the files of the contract, and bad input in one line."""

import json
from pathlib import Path

import pytest

from layouts import mechanism_of
from mechid.exports.c.compiler import find_compiler
from mechid.exports.document import PAGES
from paper_estimate import estimate_of, write_estimate_of_paper
from paper_estimate import write_estimate as write_signed


@pytest.fixture
def fit(tmp_path):
    """Return the folder of a finished fit of the paper's mechanism."""
    folder = tmp_path / "fit"
    folder.mkdir()
    write_estimate_of_paper(folder)
    return folder


def asked(fit, bench, out, target, *more):
    return ("export", fit, "--campaign", bench / "campaign.toml", "--to", target, "--out", out, *more)


@pytest.mark.parametrize(
    ("target", "files"),
    [("c", {"mechanism.c", "mechanism.h", "main.c", "CMakeLists.txt"}), ("fmu", {"{}_fmi2.fmu", "{}_fmi3.fmu"})],
)
def test_it_writes_the_files_of_the_contract(run, fit, bench, tmp_path, target, files):
    """Truth: the names, and a check that is there where a compiler is."""
    out = tmp_path / "new" / "out"
    result = run(*asked(fit, bench, out, target))
    assert result.exit_code == 0, result.stderr
    said = json.loads((out / "mechid_export.json").read_text(encoding="utf-8"))
    name = said["files"][0].removesuffix("_fmi2.fmu")
    assert set(said["files"]) == {file.format(name) for file in files}
    assert {path.name for path in out.iterdir()} == {*said["files"], *PAGES, "mechid_export.json"}
    first = result.stdout.splitlines()[0]
    assert (
        first
        == said["mechanism"]
        == ("The mechanism as it flies, without [housing]; --option stand=yes hands on the bench.")
    )
    assert said["format"] == "mechid-export/1"
    assert said["target"] == target
    assert (said["checked"] is not None) == (find_compiler() is not None)
    assert "Grade A" in " ".join(result.stdout.split())


WORDS = {
    "no": "The mechanism as it flies, without [housing]; --option stand=yes hands on the bench.",
    "yes": "The mechanism as on the bench, with [housing]; its base is at rest.",
}
QUICK = (("c", "no"), ("linear", "yes"))
"""tests/exports/test_stand.py has every target in both."""


@pytest.mark.parametrize(
    ("target", "stand"),
    [
        pytest.param(target, stand, marks=[] if (target, stand) in QUICK else [pytest.mark.slow])
        for target in ("c", "fmu", "linear", "tables")
        for stand in WORDS
    ],
)
def test_the_first_line_says_which_mechanism_it_is(run, fit, bench, tmp_path, target, stand):
    """Truth: the sentence of each, printed and in mechid_export.json; what is written passes its check."""
    more = ("--option", "rates=46") if target in ("linear", "tables") else ()
    result = run(*asked(fit, bench, tmp_path / "out", target, "--option", f"stand={stand}", *more))
    assert result.exit_code == 0, result.stderr
    said = json.loads((tmp_path / "out" / "mechid_export.json").read_text(encoding="utf-8"))
    assert result.stdout.splitlines()[0] == said["mechanism"] == said["provenance"]["mechanism"] == WORDS[stand]


def test_bad_input_in_one_line(refused, fit, bench, tmp_path):
    """Truth: usage is 2, a mechanism that a unit cannot express 3; nothing is left behind."""
    out = tmp_path / "out"
    assert "yes or no" in refused(2, *asked(fit, bench, out, "c", "--option", "sensitivities=1"))
    for target in ("c", "fmu", "linear", "tables"):
        assert "yes or no" in refused(2, *asked(fit, bench, out, target, "--option", "stand=1"))
    assert 'did you mean "stand"' in refused(2, *asked(fit, bench, out, "fmu", "--option", "stnad=yes"))
    table = {
        "assembly": "direct_torque_drive",
        "load": {"inertia": 0.01},
        "friction": {"static": 0.01, "coulomb": 0.005, "viscous": 0.01},
    }
    mechanism = mechanism_of(table)
    write_signed(fit, mechanism, estimate_of(mechanism, ["friction.coulomb"]))
    assert "--to c" in refused(3, *asked(fit, bench, out, "fmu"))
    estimate = json.loads((fit / "estimate.json").read_text(encoding="utf-8"))
    del estimate["correlation"]
    (fit / "estimate.json").write_text(json.dumps(estimate), encoding="utf-8")
    assert "correlation: missing" in refused(3, *asked(fit, bench, out, "c"))
    assert not out.exists() or not list(out.iterdir())


@pytest.mark.slow
def test_an_export_that_was_cut_short_is_made_again(run, fit, bench, tmp_path, monkeypatch):
    """Truth: the files of an undisturbed one; the first ends while they are put in place."""
    out, replaced = tmp_path / "out", Path.replace

    def cut(path, target):
        if path.name == "main.c":
            raise KeyboardInterrupt
        return replaced(path, target)

    monkeypatch.setattr(Path, "replace", cut)
    assert run(*asked(fit, bench, out, "c")).exit_code == 130
    assert (out / "mechanism.c").exists()
    monkeypatch.undo()
    assert run(*asked(fit, bench, out, "c")).exit_code == 0
    assert (out / "main.c").exists()
