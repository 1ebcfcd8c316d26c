"""The Word printer. Truth: the parts of a small document, written by hand and read back with python-docx."""

import struct
import zlib
from zipfile import ZipFile

import pytest
from docx.oxml.ns import qn

import word_files
from mechid.errors import UsageError
from mechid.ink import in_docx
from mechid.ink.document import (
    CAUTION,
    ON_TERMINAL,
    Card,
    Cards,
    Code,
    Document,
    Facts,
    Html,
    Interactive,
    Lines,
    Picture,
    Rows,
    Section,
    Verdict,
    Words,
)
from mechid.ink.docx_file import picture_files, refuse_without_docx, text_digests, write_docx
from mechid.ink.table import Table
from mechid.ink.text_table import Column

TABLE = Table((Column("mode", "name", words=True), Column("Hz", "hz")), [{"name": "tilt", "hz": "12.5"}])
DOCUMENT = Document(
    title="A rig",
    command="mechid look",
    under="made by hand",
    is_synthetic=True,
    parts=(
        Facts([("reference", "R-1")]),
        Section(
            "Modes",
            (
                Verdict("It holds.", [("Why?", ["3 < 4"])], CAUTION, Lines(["worn"], heading="Cautions")),
                Words("The **lower** limit decides."),
                Rows(TABLE, "of the base"),
                Picture("modes", "Its modes"),
                Section("", (Interactive(Picture("curves", "Its curves"), ("torque",), "a"), Picture("gone", "none"))),
                Section("Deeper", (Code("[a]\n  b = 1\n"), Rows(TABLE), Html("<b>page</b>"))),
            ),
        ),
        Section("Others", (Cards([Card(title="b", headline="worn \x07 out", cautions=["old"])]),)),
        Section("Empty", (Lines([]), Words("there", where=ON_TERMINAL))),
    ),
)


def png(path, width=40, height=20):
    """Write a white picture."""
    rows = zlib.compress((b"\0" + 3 * width * b"\xff") * height)
    chunks = [(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)), (b"IDAT", rows), (b"IEND", b"")]
    made = b"".join(struct.pack(">I", len(d)) + n + d + struct.pack(">I", zlib.crc32(n + d)) for n, d in chunks)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + made)
    return path


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pictures")
    # The second one is a hundred times as high as wide.
    png(folder / "modes.png")
    png(folder / "curves.png", 4, 400)
    return picture_files(folder, ["modes", "curves", "gone"])


@pytest.fixture(scope="module")
def written(pictures, tmp_path_factory):
    return write_docx(DOCUMENT, pictures, tmp_path_factory.mktemp("word") / "a.docx")


@pytest.fixture
def file(written):
    return word_files.opened(written)


def test_headings_are_numbered_styles(file):
    levels = [(1, "Modes"), (2, "Why?"), (2, "Cautions"), (2, "Deeper"), (1, "Others")]
    assert word_files.headings(file) == levels
    for level in (1, 2):
        numbered = file.styles[f"Heading {level}"].element.pPr.numPr
        assert (numbered.ilvl.val, numbered.numId.val) == (
            level - 1,
            file.styles["Heading 1"].element.pPr.numPr.numId.val,
        )


def test_the_contents_list_the_headings_and_lead_to_them(file):
    entries = [p for p in file.paragraphs if p.style.name.startswith("toc ")]
    assert [p.text for p in entries] == ["1\tModes", "1.1\tWhy?", "1.2\tCautions", "1.3\tDeeper", "2\tOthers"]
    links = [link.get(qn("w:anchor")) for p in entries for link in p._p.iter(qn("w:hyperlink"))]
    marks = [mark.get(qn("w:name")) for mark in file.element.body.iter(qn("w:bookmarkStart"))]
    assert links == marks
    assert 'TOC \\o "1-2"' in "".join(i.text for i in file.element.body.iter(qn("w:instrText")))


def test_tables_have_captions_and_repeated_headers(file):
    facts, first, second = file.tables
    assert word_files.cells(facts) == [["reference", "R-1"]]
    assert word_files.cells(first) == word_files.cells(second) == [["mode", "Hz"], ["tilt", "12.5"]]
    assert [word_files.repeats(row) for row in first.rows] == [True, False]
    assert word_files.captions(file) == [
        "Table 1: of the base",
        "Figure 1: Its modes",
        "Figure 2: Its curves",
        "Table 2: Deeper",
    ]


def test_pictures_fit_the_page_and_are_described(file):
    shapes = file.inline_shapes
    assert [shape._inline.docPr.get("descr") for shape in shapes] == ["Its modes", "Its curves"]
    wide, high = shapes
    assert wide.width.cm == pytest.approx(17.0, abs=0.01)
    assert high.height.cm == pytest.approx(21.0, abs=0.01)
    assert high.height / high.width == pytest.approx(100.0, rel=1e-3)


def test_words_keep_their_emphasis_and_code_its_indent(file):
    (words,) = [p for p in file.paragraphs if p.text == "The lower limit decides."]
    assert [(run.text, bool(run.bold)) for run in words.runs] == [
        ("The ", False),
        ("lower", True),
        (" limit decides.", False),
    ]
    assert [p.text for p in file.paragraphs if p.style.name == "Code"] == ["[a]", "  b = 1"]
    text = word_files.text_of(file)
    assert "b: worn \N{REPLACEMENT CHARACTER} out" in text
    assert "there" not in text.split()
    assert "<b>" not in text


def test_each_page_has_its_number_and_says_that_records_were_simulated(file):
    (section,) = file.sections
    fields = [i.text.strip() for i in section.footer._element.iter(qn("w:instrText"))]
    assert fields == ["PAGE", "NUMPAGES"]
    assert "SYNTHETIC" in section.header.paragraphs[0].text
    assert "SYNTHETIC: the records were simulated" in word_files.text_of(file)


def test_the_properties_name_the_document_and_no_person(file, written):
    own = file.core_properties
    assert (own.title, own.subject, own.author, own.last_modified_by) == ("A rig", "made by hand", "mechid", "")
    with ZipFile(written) as archive:
        core = archive.read("docProps/core.xml").decode()
        assert "created" not in core
        assert "thumbnail" not in " ".join(archive.namelist())


def test_equal_documents_have_equal_bytes(written, pictures, tmp_path):
    assert write_docx(DOCUMENT, pictures, tmp_path / "b.docx").read_bytes() == written.read_bytes()


def test_further_pictures_are_named_by_their_files(pictures, tmp_path, monkeypatch):
    monkeypatch.setattr(in_docx, "MOST_PICTURES", 1)
    file = word_files.opened(write_docx(DOCUMENT, pictures, tmp_path / "a.docx"))
    assert len(file.inline_shapes) == 1
    assert "Its curves: figures/curves.png" in word_files.text_of(file)


def test_without_python_docx_the_command_to_type_is_said(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "docx", None)
    with pytest.raises(UsageError, match=r'pip install "mechid\[office\]"'):
        refuse_without_docx()


def test_digests_are_of_numbers_alone(tmp_path):
    """Truth: the digest of an empty file."""
    for name in ("a.json", "b.csv", "c.xlsx", "d.html"):
        (tmp_path / name).touch()
    empty = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"
    assert text_digests(tmp_path.iterdir()) == {"a.json": empty, "b.csv": empty}


@pytest.mark.slow
def test_libreoffice_opens_it_and_shows_every_word(written, tmp_path):
    """Truth: the text that LibreOffice makes of the file, and pdftotext reads."""
    pages = word_files.printed(written, tmp_path)
    for words in ("1 Modes", "1.3 Deeper", "Table 1: of the base", "Figure 2: Its curves", "Page 1 of"):
        assert words in pages
