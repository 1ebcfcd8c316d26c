"""An export as a whole: its options, and what it replaces. Truth: the files that are there before and after."""

import pytest

from mechid.errors import UsageError
from mechid.exports.export import FILE_NAME, read_options, write_export
from mechid.exports.tables.options import Options


def test_options_of_another_kind_are_refused(paper, tmp_path):
    """Truth: nothing is written."""
    with pytest.raises(UsageError, match="options of another target"):
        write_export(paper, "tables", tmp_path / "out", object())
    assert not (tmp_path / "out").exists()


def test_a_target_that_there_is_not_is_refused_with_the_nearest(paper, tmp_path):
    with pytest.raises(UsageError, match='found "table"; did you mean "tables"'):
        write_export(paper, "table", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_file_of_somebody_else_is_not_replaced(tables, tmp_path):
    """Truth: its bytes; what an earlier export has left is replaced, by the list that stands in its own file."""
    out = tmp_path / "out"
    out.mkdir()
    (out / "parameters.csv").write_text("mine", encoding="utf-8")
    with pytest.raises(UsageError, match=r"holds parameters[.]csv, which no export of mechid has left"):
        write_export(tables.what, "tables", out, Options(rates=(23.0,)))
    assert {path.name: path.read_text(encoding="utf-8") for path in out.iterdir()} == {"parameters.csv": "mine"}
    (out / FILE_NAME).write_text('{"files": ["parameters.csv"]}', encoding="utf-8")
    done = write_export(tables.what, "tables", out, Options(rates=(23.0,)))
    assert done.earlier == (FILE_NAME, "parameters.csv")
    assert (out / "parameters.csv").read_text(encoding="utf-8") != "mine"


def test_a_page_of_somebody_else_is_not_replaced(tables, tmp_path):
    """Truth: its bytes; the page of an earlier export is replaced."""
    page = tmp_path / "mechid_export.html"
    page.write_text("mine", encoding="utf-8")
    with pytest.raises(UsageError, match=r"holds mechid_export[.]html, which no export of mechid has left"):
        write_export(tables.what, "tables", tmp_path, Options(rates=(23.0,)))
    assert page.read_text(encoding="utf-8") == "mine"
    (tmp_path / FILE_NAME).write_text('{"files": []}', encoding="utf-8")
    write_export(tables.what, "tables", tmp_path, Options(rates=(23.0,)))
    assert page.read_text(encoding="utf-8") != "mine"


@pytest.mark.parametrize(
    ("texts", "why"),
    [(["rates"], "which has no value"), (["=23"], "which has no name"), (["a=1", "a=2"], "which is there twice")],
)
def test_an_option_without_name_or_value_is_refused(texts, why):
    with pytest.raises(UsageError, match=why):
        read_options(texts)
    assert read_options(["rates = 23,46", "node=1=2"]) == {"rates": "23,46", "node": "1=2"}
