"""The document of a design. Truth: the dict of its numbers, and its page in a real browser."""

import pytest

from browser import chromium, faults, requests, shown
from mechid.designs.document import PRESENTER
from mechid.designs.sentences import headline
from mechid.ink.document import Section
from printing import printed, tables


@pytest.mark.parametrize("width", [80, 120, 200])
def test_a_terminal_has_headline_tables_and_candidates_left_out(data, width):
    text = printed(PRESENTER.print, data, width)
    words = text.split()
    assert text.startswith(headline(data))
    for row in (*data["chosen"]["records"], *data["parameters"]):
        assert row["name"] in words
    assert "left out: full_600: loses steps at the values believed" in text
    assert len(tables(text)) == 3


def test_page_and_markdown_say_what_the_terminal_does(data, folder):
    for name, refused in (("design.html", "full_600"), ("design.md", "full\\_600")):
        text = (folder / name).read_text(encoding="utf-8")
        assert headline(data) in text
        assert f"{refused}: loses steps at the values believed" in text


def test_rivals_come_before_errors(data):
    """Truth: the order of a document's sections."""
    group = {"names": ["a", "b"], "now": {"a": 2.0, "b": 0.0}, "told_already": True, "needed": 61.0, "pairs": []}
    parts = PRESENTER.document({**data, "rivals": [group]}).parts
    keys = [one.key for one in parts if isinstance(one, Section)]
    assert keys == ["rivals", "errors", "records", "step-loss", "torque", "left-out"]


def test_every_picture_of_the_page_is_drawn(folder, data):
    names = {path.stem for path in (folder / "figures").glob("*.svg")}
    text = (folder / "design.html").read_text(encoding="utf-8")
    assert {name for name in names if f'id="figure-{name}"' in text} == names
    assert names == {"standard_errors", "errors_by_record", "record_rates", "step_loss", "torque_over_rate"}


@pytest.fixture(scope="module")
def browser():
    with chromium() as opened:
        yield opened


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("width", [1400, 390])
def test_the_page_opens_without_network_or_error_and_without_overflow(browser, folder, width, dark):
    page = folder / "design.html"
    shown(browser, page, width, dark=dark)
    assert requests(browser) == [page.as_uri()]
    assert faults(browser) == []
    assert browser.execute_script("return document.documentElement.scrollWidth") <= width
