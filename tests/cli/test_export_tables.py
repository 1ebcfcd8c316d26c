"""``mechid export FIT --to tables`` from a result folder to its files, and what it refuses in one line."""

import json

import pytest

from mechid.exports.document import PAGES
from nastran_cards import cards
from paper_estimate import write_estimate_of_paper


@pytest.fixture
def fit(folder):
    """Return a result folder: a bench's campaign with the paper's estimate beside it."""
    write_estimate_of_paper(folder, fit_percent=99.0)
    return folder


def test_tables_from_folder_to_folder(run, fit, tmp_path):
    """Truth: the options, and that every file named is there."""
    options = ("--option", "rates=46", "--option", "node=1001", "--option", "component=4", "--option", "scale=1000")
    result = run("export", fit, "--to", "tables", "--out", tmp_path / "out", *options)
    assert result.exit_code == 0, result.stderr
    done = json.loads((tmp_path / "out" / "mechid_export.json").read_text(encoding="utf-8"))
    assert {p.name for p in (tmp_path / "out").iterdir()} == {*done["files"], *PAGES, "mechid_export.json"}
    assert {"tables.xlsx", "lines.csv", "lines.bdf", "history_sweep.csv"} <= set(done["files"])
    (area,) = [fields for name, fields in cards(tmp_path / "out" / "lines.bdf") if name == "DAREA"]
    assert area[1:4] == [1001, 4, 1000.0]
    assert "Checked against direct simulations from rest" in " ".join(result.stdout.split())


@pytest.mark.parametrize(
    ("option", "said"),
    [
        ("nodes=4", 'found "nodes"; did you mean "node"?'),
        ("node", 'found "node", which has no value; write NAME=VALUE'),
        ("rates=0", "rates: found 0; write full steps/s from 0.02"),
    ],
)
def test_an_option_that_cannot_be_is_one_line(refused, fit, tmp_path, option, said):
    """Truth: exit code 2, and nothing is left in the folder."""
    out = tmp_path / "out"
    assert said in refused(2, "export", fit, "--to", "tables", "--out", out, "--option", option)
    assert not out.exists() or not any(out.iterdir())


def test_another_fits_residual_is_one_line(refused, fit, tmp_path):
    """Truth: exit code 3, a file that was put there by hand."""
    (fit / "residual.json").write_text("{}", encoding="utf-8")
    line = refused(3, "export", fit, "--to", "tables", "--out", tmp_path / "out")
    assert "residual.json: is damaged at 'format'" in line
