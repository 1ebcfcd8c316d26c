"""The page of an index in a real browser. Truth: what its files hold, and the one address that a page lets through."""

import pytest

import mechid
from browser import chromium, faults, shown
from mechid.ink.document import Document
from mechid.ink.on_page import document_page
from results_by_hand import write, write_budget, write_fit

WIDTH = "return document.documentElement.scrollWidth - document.documentElement.clientWidth;"
PICTURE = """
const picture = document.querySelector('.card img');
picture.loading = 'eager'; await picture.decode(); return picture.naturalWidth;
"""
BACK = "const a = document.getElementById('index'); return a.hidden ? '' : a.href;"


@pytest.fixture(scope="module")
def browser():
    with chromium() as opened:
        yield opened


@pytest.fixture
def bench(tmp_path):
    """Return a folder with a fit whose page is as mechid makes one, a budget of an unknown fit and a damaged look."""
    write_fit(tmp_path / "FM1" / "fit")
    write(tmp_path / "FM1" / "fit" / "report.html", document_page(Document(title="A fit", command="mechid report"), {}))
    write_budget(tmp_path / ("a_long_name_without_any_place_to_break_it_" * 3), "ab" * 32)
    write(tmp_path / "look" / "look.json", "{")
    mechid.open_results(tmp_path)
    return tmp_path


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("width", [1400, 390])
def test_an_index_shows_its_pictures_and_is_no_wider_than_the_screen(browser, bench, width, dark):
    shown(browser, bench / "index.html", width, dark=dark)
    assert len(browser.find_elements("css selector", ".card")) == 3
    script = f"const done = arguments[0]; (async () => {{ {PICTURE} }})().then(done, (e) => done(String(e)));"
    assert browser.execute_async_script(script) == 9  # the width that the file states
    assert browser.execute_script(WIDTH) <= 0
    assert faults(browser) == []


def test_a_page_leads_back_to_the_index_that_leads_to_it_and_nowhere_else(browser, bench):
    browser.get((bench / "index.html").as_uri())
    browser.find_element("css selector", ".card a").click()
    assert browser.title == "A fit · mechid report"
    assert browser.execute_script(BACK) == (bench / "index.html").as_uri()
    page = (bench / "FM1" / "fit" / "report.html").as_uri()
    for bad in ("", "?index=javascript:alert(1)", "?index=//evil.example/index.html", "?index=../other.html"):
        browser.get(page + bad)
        assert browser.execute_script(BACK) == ""
