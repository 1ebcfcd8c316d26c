"""The document of an export. Truth: the numbers of mechid_export.json."""

from mechid.exports.document import PRESENTER, export_numbers
from mechid.ink.in_markdown import document_markdown


def test_a_terminal_has_each_file_by_its_path_behind_the_mechanism(tables):
    lines = str(tables.done).splitlines()
    assert lines[0] == tables.done.provenance["mechanism"]
    assert lines[1 : 1 + len(tables.done.written.files)] == [
        str(tables.folder / name) for name in tables.done.written.files
    ]
    assert tables.done.provenance["trust"].split()[0] in " ".join(lines)


def test_the_page_and_the_markdown_say_what_was_written_and_checked(tables):
    checked = f"Checked against {tables.done.written.checked.against}"
    for name in ("mechid_export.html", "mechid_export.md"):
        text = (tables.folder / name).read_text(encoding="utf-8").replace("\\_", "_")
        assert all(file in text for file in tables.done.written.files)
        assert checked in text
        assert not any(str(tables.folder / file) in text for file in tables.done.written.files)


def test_an_export_that_could_not_be_checked_says_so(tables):
    data = {**export_numbers(tables.done), "checked": None}
    assert "Not checked." in document_markdown(PRESENTER.document(data))
