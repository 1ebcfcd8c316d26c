"""A document and its three printers. Truth: the parts of a small document, written out by hand."""

import pytest

from mechid.ink.document import (
    GOOD,
    IN_DOCUMENTS,
    MOST_ENTRIES,
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
    shown_on,
)
from mechid.ink.in_markdown import document_markdown
from mechid.ink.on_page import MOST_PICTURES, Script, document_page, interactive_page
from mechid.ink.on_terminal import print_document
from mechid.ink.table import Table
from mechid.ink.text_table import MARKDOWN, TERMINAL, Column, OnPage
from printing import printed

TABLE = Table((Column("mode", "name", words=True), Column("Hz", "hz")), [{"name": "tilt", "hz": "12.5"}])
DOCUMENT = Document(
    title="A rig",
    command="mechid look",
    under="made by hand",
    is_synthetic=True,
    parts=(
        Verdict("It holds.", [("Why?", ["3 < 4"])], GOOD, Lines(["worn"], "caution", "Cautions")),
        Words("The **lower** limit decides.", where=IN_DOCUMENTS),
        Lines(["a_b"], "note"),
        Section(
            "Modes",
            (
                Rows(TABLE, "of the base"),
                Facts([("largest at, Hz", "12.5")]),
                Picture("modes", "Its modes"),
                Section("Deeper", (Code("[a]\n", summary="What declares it"),), "deeper", is_folded=True),
            ),
            "modes",
            "Modes",
        ),
        Section("Nothing", (Lines([]), Rows(Table(TABLE.columns, []))), "nothing", "Nothing"),
        Words("seen there alone", where=ON_TERMINAL),
    ),
)
MARKDOWN_TEXT = """# A rig

**Synthetic**: the records were simulated, nothing of this was measured.

made by hand

**It holds.**

## Why?

- 3 \\< 4

## Cautions

- worn

The **lower** limit decides.

- a\\_b

## Modes

of the base

| mode | Hz |
| --- | --- |
| tilt | 12.5 |

- largest at, Hz: **12.5**

![Its modes](<figures/modes.svg>)

### Deeper

```toml
[a]
```
"""


def test_a_terminal_has_lines_and_tables():
    lines = [line for line in printed(print_document, DOCUMENT, 100).splitlines() if line]
    assert lines == [
        "SYNTHETIC: the records were simulated, nothing of this was measured.",
        "It holds.",
        "Why?",
        "  3 < 4",
        "caution: worn",
        "note: a_b",
        "Modes",
        "of the base",
        "mode    Hz",
        "----  ----",
        "tilt  12.5",
        "  largest at, Hz: 12.5",
        "seen there alone",
    ]


def test_a_terminal_has_an_empty_line_between_sections():
    """Truth: behind lines; a table has one of its own, and a section within another none."""
    inner = Section("Inner", (Words("deep"),))
    parts = (Section("A", (Lines(["1"]), inner)), Section("B", (Rows(TABLE),)), Words("end"))
    text = printed(print_document, Document(title="t", command="c", parts=parts), 80)
    assert text == "A\n  1\nInner\ndeep\n\nB\nmode    Hz\n----  ----\ntilt  12.5\n\nend\n"


def test_markdown_has_every_block_on_its_own():
    assert document_markdown(DOCUMENT) == MARKDOWN_TEXT


def test_a_page_has_contents_that_lead_to_sections():
    page = document_page(DOCUMENT, {"modes": '<svg width="9pt" height="4pt"></svg>'})
    assert '<a href="#modes">Modes</a>' in page
    assert '<h2 id="modes">Modes</h2>' in page
    assert "<summary>Deeper</summary>" in page
    assert "The <b>lower</b> limit decides." in page
    assert "3 &lt; 4" in page
    assert 'aria-label="Its modes"' in page
    assert "<span>largest at, Hz</span> <b>12.5</b>" in page
    assert 'id="nothing"' not in page
    assert "seen there alone" not in page
    assert "<title>A rig · mechid look</title>" in page
    assert 'class="synthetic"' in page


def test_what_holds_nothing_is_shown_nowhere():
    """Truth: a section of an empty list and an empty table."""
    assert not shown_on(DOCUMENT.parts[4:5], MARKDOWN)
    assert not shown_on((Section("Seen", (Words("on paper", where=IN_DOCUMENTS),)),), TERMINAL)
    assert DOCUMENT.contents() == [("", [DOCUMENT.parts[3]])]


TRACE = Interactive(
    Picture("full_46_torque", "Torque of full_46"), ("density", "correlation"), "full_46", [("start", 0.0, 0.5)]
)


@pytest.mark.parametrize("count", [1, MOST_PICTURES + 1])
def test_an_interactive_figure_has_its_picture_on_paper_or_its_name_where_there_are_many(tmp_path, count):
    """Truth: the file of the picture; Markdown shows it, a terminal has nothing of it."""
    file = tmp_path / "figures" / "full_46_torque.svg"
    file.parent.mkdir()
    file.write_text("<svg/>")
    document = Document(title="A fit", command="mechid report", parts=(TRACE, Html("<math>x</math>")))
    pictures = {"full_46_torque": file, **{str(k): file for k in range(1, count)}}
    script = Script(library="bG9uZw==", kinds={"density": {"a": "</script>"}}, records=[{"name": "full_46"}])
    page = "".join(interactive_page(document, pictures, script))
    assert 'id="density-full_46" data-kind="density" data-record="full_46"' in page
    assert 'data-figure="density-full_46" data-from="0.0" data-to="0.5">start</button>' in page
    assert ["data:image/svg+xml;base64,PHN2Zy8+" in page, "figures/full_46_torque.svg" in page] == [
        count == 1,
        count > 1,
    ]
    assert "<math>x</math>" in page
    assert page.count("</script>") == 5
    assert document_markdown(document) == "# A fit\n\n![Torque of full\\_46](<figures/full_46_torque.svg>)\n"
    assert not shown_on(document.parts, TERMINAL)


@pytest.mark.parametrize("count", [MOST_ENTRIES, MOST_ENTRIES + 1])
def test_the_contents_fold_many_sections_of_a_group_away(count):
    sections = [Section(str(k), (Words("one"),), f"key-{k}", str(k)) for k in range(count)]
    document = Document(title="", command="", parts=(Section("", sections, entry="records"),))
    many = [(f"{count} records", sections)]
    assert document.contents() == (many if count > MOST_ENTRIES else [("", [one]) for one in sections])


def test_a_cell_is_the_darker_the_larger_its_value():
    """Truth: the opacity by hand, 0.75 at the most."""
    on_page = OnPage(heat=lambda row: row["off"] / 6.0)
    rows = [{"name": "a", "off": off, "text": {"off": f"{off:g}"}} for off in (3.0, -6.0, 0.0)]
    page = Table(
        (Column("unit", "name", words=True), Column("off", "off", on_page=on_page)), rows, style="units"
    ).html()
    assert '<table class="units">' in page
    assert 'style="background: rgba(var(--heat), 0.38)"' in page
    assert 'style="background: rgba(var(--cold), 0.75)"' in page
    assert '<td class="number" data-label="off">0</td>' in page


def test_parts_side_by_side_are_one_block_each():
    parts = (Lines(["quiet"], "noise", "Noise"), Lines(["none"], "mains", "Mains"))
    document = Document(title="t", command="c", parts=(Section("Torque", parts, side_by_side=True),))
    blocks = "".join(document_page(document, {}).split('<div class="answers">')[1].split())
    assert blocks.startswith("<div><h3>Noise</h3><ul><li>quiet</li></ul></div><div><h3>Mains</h3>")
    assert printed(print_document, document, 80).splitlines() == ["Torque", "noise: quiet", "mains: none"]


CARD = Card(
    title="fit",
    headline="Grade B",
    link="fit/report.html",
    tone=GOOD,
    cautions=["stale"],
    picture="a.svg",
    command="mechid x",
)
SHELF = Document(title="Results", command="mechid open", parts=(Cards([CARD]), Cards([])), shows_files=True)


def test_a_card_leads_to_the_page_of_its_result():
    page = document_page(SHELF, {})
    assert '<a href="fit/report.html">fit</a>' in page
    assert '<img loading="lazy" alt="" src="a.svg">' in page
    assert "img-src data: 'self' file:" in page
    assert "file:" not in document_page(DOCUMENT, {})
    assert printed(print_document, SHELF, 80).splitlines() == ["  fit: Grade B", "  caution: stale"]
    assert document_markdown(SHELF) == "# Results\n\n[fit](<fit/report.html>): Grade B\n\n- caution: stale\n"
