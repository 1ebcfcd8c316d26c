"""Presenter of results. Truth: the texts and digests of a small result."""

import hashlib

import pytest

import word_files
from mechid.errors import UsageError
from mechid.ink.document import Document, Lines, Section, Words
from mechid.ink.presenter import Presenter

DOCUMENT = Document(title="A rig", command="mechid look", parts=(Words("It holds."),))


def report(numbers, document, files):
    lines = [f"{name} {digest}" for name, digest in files.items()]
    return Document(title="Report", command=document.command, parts=(Section(f"n = {numbers['n']}", [Lines(lines)]),))


PLAIN = {
    "name": "rig",
    "numbers": lambda result: {"n": result},
    "document": lambda numbers: DOCUMENT,
    "line": str,
    "texts": lambda result, numbers: {"rig.json": "{}\n", "rig.txt": "left\n"},
}


def test_page_and_texts_are_written(tmp_path):
    files = Presenter(**PLAIN).write(3, {"n": 3}, tmp_path)
    assert [path.name for path in files] == ["rig.json", "rig.txt", "rig.md", "rig.html"]
    assert "It holds." in (tmp_path / "rig.md").read_text(encoding="utf-8")


def test_the_test_report_comes_last_with_the_digests_of_the_numbers(tmp_path):
    files = Presenter(**PLAIN, report=report).write(3, {"n": 3}, tmp_path, docx=True)
    assert files[-1] == tmp_path / "rig.docx"
    file = word_files.opened(files[-1])
    assert word_files.headings(file) == [(1, "n = 3")]
    digest = hashlib.sha256(b"{}\n").hexdigest()
    assert [p.text for p in file.paragraphs if p.style.name == "List Bullet"] == [f"rig.json {digest}"]


def test_without_the_option_or_a_report_there_is_no_word_file(tmp_path):
    Presenter(**PLAIN, report=report).write(3, {"n": 3}, tmp_path / "a")
    assert not (tmp_path / "a" / "rig.docx").exists()
    with pytest.raises(UsageError, match="docx: no test report is made of a int; leave it out"):
        Presenter(**PLAIN).write(3, {"n": 3}, tmp_path / "b", docx=True)
    assert not (tmp_path / "b").exists()
