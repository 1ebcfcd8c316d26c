"""Layout of Word documents. Truth: the size of A4, and the properties that a reader sees."""

import pytest

from mechid.ink.document import Document
from mechid.ink.docx_layout import LONGEST_PROPERTY, WIDTH_CM, new_file

LONG = 40 * "long name "


@pytest.fixture(scope="module")
def file():
    return new_file(Document(title=LONG, command="mechid emission", under=LONG))


def test_the_page_is_a4_and_the_text_as_wide_as_a_figure(file):
    (section,) = file.sections
    assert (section.page_width.mm, section.page_height.mm) == (
        pytest.approx(210.0, abs=0.1),
        pytest.approx(297.0, abs=0.1),
    )
    text = section.page_width - section.left_margin - section.right_margin
    assert text / 360_000 == pytest.approx(WIDTH_CM, abs=0.01)


def test_a_long_title_is_cut_where_there_is_no_room_for_it(file):
    assert len(file.core_properties.title) == LONGEST_PROPERTY
    assert len(file.sections[0].header.paragraphs[0].text.strip()) <= 90


def test_measured_records_bear_no_remark(file):
    assert "SYNTHETIC" not in file.sections[0].header.paragraphs[0].text
    assert "mechid emission, mechid " in file.sections[0].footer.paragraphs[0].text


@pytest.mark.parametrize("name", ["Title", "Heading 1", "Heading 9", "Caption", "List Bullet", "Table Text", "Normal"])
def test_every_style_has_one_font_and_none_of_the_theme(file, name):
    fonts = file.styles[name].element.rPr.rFonts
    assert set(fonts.attrib.values()) == {"Arial"}
