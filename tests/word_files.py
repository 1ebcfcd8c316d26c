"""Word files read back with python-docx, and printed by LibreOffice."""

import shutil
import subprocess
from pathlib import Path

import pytest
from docx import Document
from docx.oxml.ns import qn


def opened(path):
    """Return the document in a file, after a check that it is whole."""
    return Document(str(path))


def headings(file):
    """Return level and text of each heading."""
    own = [p for p in file.paragraphs if p.style.name.startswith("Heading ")]
    return [(int(p.style.name.removeprefix("Heading ")), p.text) for p in own]


def captions(file):
    return [p.text for p in file.paragraphs if p.style.name == "Caption"]


def cells(table):
    """Return the texts of a table, row by row."""
    return [[cell.text for cell in row.cells] for row in table.rows]


def repeats(row):
    """Whether Word repeats a row at the head of each page."""
    return bool(row._tr.findall(f"{qn('w:trPr')}/{qn('w:tblHeader')}"))


def table_under(file, caption):
    """Return the texts of the first table whose caption ends with some words."""
    body = list(file.element.body)
    (k,) = [k for k, e in enumerate(body) if "".join(t.text or "" for t in e.iter(qn("w:t"))).endswith(f": {caption}")]
    found = next(e for e in body[k:] if e.tag == qn("w:tbl"))
    return next(cells(table) for table in file.tables if table._tbl is found)


def text_of(file):
    """Return all paragraphs outside of tables."""
    return "\n".join(p.text for p in file.paragraphs)


def printed(path, folder):
    """Return the text of the pages that LibreOffice prints; skips where it is not installed."""
    if not (shutil.which("soffice") and shutil.which("pdftotext")):
        pytest.skip("needs soffice (LibreOffice) and pdftotext (poppler)")
    profile = f"-env:UserInstallation={(folder / 'profile').as_uri()}"
    command = ["soffice", profile, "--headless", "--convert-to", "pdf", "--outdir", folder, path]
    subprocess.run(command, check=True, capture_output=True, timeout=300)
    pdf = folder / f"{Path(path).stem}.pdf"
    done = subprocess.run(["pdftotext", "-layout", pdf, "-"], check=True, capture_output=True, timeout=60, text=True)
    return " ".join(done.stdout.split())
