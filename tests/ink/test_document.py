"""A document and its three printers. Truth: the parts of a small document, written out by hand."""

from mechid.ink.document import (
    GOOD,
    IN_DOCUMENTS,
    ON_TERMINAL,
    Card,
    Cards,
    Code,
    Document,
    Facts,
    Lines,
    Picture,
    Rows,
    Section,
    Verdict,
    Words,
    shown_on,
)
from mechid.ink.in_markdown import document_markdown
from mechid.ink.on_page import document_page
from mechid.ink.on_terminal import print_document
from mechid.ink.table import Table
from mechid.ink.text_table import MARKDOWN, TERMINAL, Column
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

**Synthetic**: the records were simulated; nothing of this was measured.

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
    assert [one.key for one in DOCUMENT.sections()] == ["modes"]


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
