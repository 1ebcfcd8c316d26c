"""Layout of a Word document: page, styles, numbered headings, header, footer, properties."""

from __future__ import annotations

from importlib.metadata import version
from textwrap import shorten
from typing import Any

import docx
from docx.document import Document as WordFile
from docx.enum.style import WD_STYLE_TYPE
from docx.enum.text import WD_TAB_ALIGNMENT, WD_TAB_LEADER
from docx.opc.constants import RELATIONSHIP_TYPE
from docx.oxml import parse_xml
from docx.oxml.ns import nsdecls, qn
from docx.shared import Cm, Pt, RGBColor

from mechid.ink.document import Document
from mechid.ink.docx_text import TAB, clean, elements, field, paragraph, run

PAGE_CM, MARGIN_CM = (21.0, 29.7), (2.0, 2.2)
"""Size of the page (A4), and margins at the sides and above and below."""
WIDTH_CM = PAGE_CM[0] - 2.0 * MARGIN_CM[0]
WIDTH_PT = WIDTH_CM / 2.54 * 72.0
"""Width of the text."""
FONT, MONOSPACED = "Arial", "Courier New"
DARK, GREY = "1F3A5F", "5A6570"
HEADING_PT = (15.0, 12.5, 11.0, 10.0, 10.0, 10.0, 10.0, 10.0, 10.0)
LIST_ID = 90
"""Number of the list of headings, above those of the template."""
LEVELS = len(HEADING_PT)
SHOWN_TITLE = 90
"""Most characters of the title at the head of a page."""
LONGEST_PROPERTY = 255
"""Most characters of a property, as python-docx has it."""
TABLE_STYLE = f"""
<w:style {nsdecls("w")} w:type="table" w:customStyle="1" w:styleId="TableLines">
  <w:name w:val="Table Lines"/><w:basedOn w:val="TableNormal"/>
  <w:tblPr><w:tblBorders>
    <w:top w:val="single" w:sz="6" w:color="{GREY}"/><w:bottom w:val="single" w:sz="6" w:color="{GREY}"/>
    <w:insideH w:val="single" w:sz="4" w:color="C5CCD3"/>
  </w:tblBorders><w:tblCellMar>
    <w:top w:w="20" w:type="dxa"/><w:left w:w="60" w:type="dxa"/>
    <w:bottom w:w="20" w:type="dxa"/><w:right w:w="60" w:type="dxa"/>
  </w:tblCellMar></w:tblPr>
</w:style>"""


def new_file(document: Document) -> WordFile:
    """Return an empty Word document with the styles, header, footer and properties of a document."""
    file = docx.Document()
    _set_page(file)
    _set_styles(file)
    _number_headings(file)
    _set_header_and_footer(file, document)
    _set_properties(file, document)
    return file


def _set_page(file: WordFile) -> None:
    section = file.sections[0]
    section.page_width, section.page_height = (Cm(size) for size in PAGE_CM)
    section.left_margin = section.right_margin = Cm(MARGIN_CM[0])
    section.top_margin = section.bottom_margin = Cm(MARGIN_CM[1])


def _set_styles(file: WordFile) -> None:
    styles: Any = file.styles
    _style(styles["Normal"], 10.0, after=6.0)
    styles["Normal"].paragraph_format.line_spacing = 1.1
    _style(styles["Title"], 22.0, bold=True, colour=DARK, before=30.0, after=6.0)
    # The template draws a line below the title.
    _remove(styles["Title"].element, "w:pBdr")
    _style(styles["Subtitle"], 12.0, colour=GREY, after=12.0)
    styles["Subtitle"].font.italic = False
    _remove(styles["Subtitle"].element.rPr, "w:spacing")
    _style(styles["Caption"], 8.5, bold=True, colour=GREY, before=6.0, after=3.0)
    _style(styles["List Bullet"], 10.0, after=3.0)
    for level, size in enumerate(HEADING_PT, 1):
        heading = styles[f"Heading {level}"]
        _style(heading, size, bold=True, colour=DARK, before=size + 3.0, after=0.4 * size)
        heading.font.italic = False
    for name, size, bold, colour in (
        ("Table Text", 8.5, False, ""),
        ("Note", 9.0, False, GREY),
        ("Verdict", 12.0, True, ""),
        ("Picture", 10.0, False, ""),
        ("Code", 8.5, False, ""),
        ("Contents Heading", 13.0, True, DARK),
        ("toc 1", 10.0, False, ""),
        ("toc 2", 9.5, False, ""),
    ):
        _style(styles.add_style(name, WD_STYLE_TYPE.PARAGRAPH), size, bold=bold, colour=colour, after=4.0)
    styles["Table Text"].paragraph_format.space_after = Pt(0.0)
    styles["Table Text"].paragraph_format.line_spacing = 1.0
    styles["Picture"].paragraph_format.keep_with_next = True
    styles["Code"].paragraph_format.space_after = Pt(0.0)
    _set_font(styles["Code"], MONOSPACED)
    for level in (1, 2):
        style = styles[f"toc {level}"]
        style.paragraph_format.left_indent = Cm(0.6 * (level - 1))
        style.paragraph_format.space_after = Pt(1.0)
        style.paragraph_format.tab_stops.add_tab_stop(Cm(1.0 * level))
        # Programs that make the contents anew enter the page numbers behind this one.
        style.paragraph_format.tab_stops.add_tab_stop(Cm(WIDTH_CM), WD_TAB_ALIGNMENT.RIGHT, WD_TAB_LEADER.DOTS)
    styles.element.append(parse_xml(TABLE_STYLE))


def _style(
    style: Any, size: float, *, bold: bool = False, colour: str = "", before: float = 0.0, after: float = 0.0
) -> None:
    _set_font(style, FONT)
    style.font.size, style.font.bold = Pt(size), bold
    style.font.color.rgb = RGBColor.from_string(colour or "000000")
    style.paragraph_format.space_before, style.paragraph_format.space_after = Pt(before), Pt(after)


def _set_font(style: Any, name: str) -> None:
    properties = style.element.get_or_add_rPr()
    _remove(properties, "w:rFonts")
    # The fonts of the template's theme would win over a name that is given beside them.
    properties.insert(0, parse_xml(f'<w:rFonts {nsdecls("w")} w:ascii="{name}" w:hAnsi="{name}" w:cs="{name}"/>'))


def _remove(element: Any, tag: str) -> None:
    for found in element.findall(f".//{qn(tag)}"):
        found.getparent().remove(found)


def _number_headings(file: WordFile) -> None:
    """Add the list by which headings are numbered as 1, 1.1, 1.1.1."""
    numbering = file.part.numbering_part.element
    shown = [".".join(f"%{j + 1}" for j in range(k + 1)) for k in range(LEVELS)]
    levels = "".join(
        f'<w:lvl w:ilvl="{k}"><w:start w:val="1"/><w:numFmt w:val="decimal"/><w:pStyle w:val="Heading{k + 1}"/>'
        f'<w:suff w:val="tab"/><w:lvlText w:val="{shown[k]}"/><w:lvlJc w:val="left"/>'
        f'<w:pPr><w:tabs><w:tab w:val="num" w:pos="{_indent(k)}"/></w:tabs>'
        f'<w:ind w:left="{_indent(k)}" w:hanging="{_indent(k)}"/></w:pPr></w:lvl>'
        for k in range(LEVELS)
    )
    numbering.insert(
        0,
        parse_xml(
            f'<w:abstractNum {nsdecls("w")} w:abstractNumId="{LIST_ID}">'
            f'<w:multiLevelType w:val="multilevel"/>{levels}</w:abstractNum>'
        ),
    )
    number = numbering.add_num(LIST_ID).numId
    for k in range(LEVELS):
        properties: Any = file.styles[f"Heading {k + 1}"].element.get_or_add_pPr()
        listed = properties.get_or_add_numPr()
        listed.get_or_add_ilvl().val = k
        listed.get_or_add_numId().val = number


def _indent(level: int) -> int:
    """Return the room for the number of a heading in twips."""
    return 480 + 180 * level


def _set_header_and_footer(file: WordFile, document: Document) -> None:
    section = file.sections[0]
    title = shorten(clean(document.title), SHOWN_TITLE, placeholder="…")
    head = run(title, size=16, colour=GREY) + TAB
    # The remark stands on every page, since pages of a report are copied one by one.
    head += run("SYNTHETIC: simulated records", bold=True, size=16, colour="B00020") if document.is_synthetic else ""
    made = run(f"{document.command}, mechid {version('mechid')}", size=16, colour=GREY)
    pages = run("Page ", size=16, colour=GREY) + field("PAGE", "1") + run(" of ", size=16, colour=GREY)
    foot = made + TAB + pages + field("NUMPAGES", "1")
    for part, content in ((section.header, head), (section.footer, foot)):
        (block,) = elements([paragraph(content, "Header" if part is section.header else "Footer")])
        own: Any = part._element
        for old in list(own):
            own.remove(old)
        own.append(block)
    for name in ("Header", "Footer"):
        style: Any = file.styles[name]
        _style(style, 8.0, colour=GREY)
        # The template's tab stops are those of another page.
        _remove(style.element, "w:tabs")
        style.paragraph_format.tab_stops.add_tab_stop(Cm(WIDTH_CM), WD_TAB_ALIGNMENT.RIGHT)


def _set_properties(file: WordFile, document: Document) -> None:
    """Set title and subject, and remove what would name a person or differ from run to run."""
    properties: Any = file.core_properties
    properties.title = clean(document.title)[:LONGEST_PROPERTY]
    properties.subject = clean(document.under)[:LONGEST_PROPERTY]
    properties.category, properties.language = document.command, "en"
    properties.author, properties.last_modified_by, properties.comments = "mechid", "", ""
    for tag in ("dcterms:created", "dcterms:modified", "cp:lastModifiedBy"):
        _remove(properties._element, tag)
    for key, relation in list(file.part.package.rels.items()):
        # A picture of the template's first page.
        if relation.reltype == RELATIONSHIP_TYPE.THUMBNAIL:
            del file.part.package.rels[key]
