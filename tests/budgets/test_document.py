"""The report of a budget. Truth: the dict of its numbers, and its page in a real browser."""

import copy
import io
import itertools
import re

import pytest
from rich.console import Console

from browser import chromium, faults, printed_to_pdf, requests, shown
from mechid.budgets.document import PRESENTER
from mechid.budgets.figures import budget_figures
from mechid.budgets.texts import add_texts, mode_key
from small_budget import HOSTILE


@pytest.mark.parametrize("is_so", [True, False])
def test_terminal_page_and_markdown_say_that_records_were_simulated(data, write_report, tmp_path, is_so):
    """Truth: what the estimate says."""
    changed = {**data, "synthetic": is_so}
    console = Console(width=200, file=io.StringIO())
    PRESENTER.print(changed, console)
    write_report(changed, tmp_path)
    said = [(tmp_path / name).read_text(encoding="utf-8") for name in ("budget.html", "budget.md")]
    for text in (console.file.getvalue(), *said):
        assert ("records were simulated" in text) == is_so


def test_files(report, data):
    names = {p.name for p in report.iterdir()}
    assert names == {"budget.html", "budget.md", "figures"}
    keys = [mode_key(k, mode["name"]) for k, mode in enumerate(data["modes"])]
    assert keys == ["0_scan", "1_slew", "2_img_src_x_onerror_document_title_taken"]
    figures = {p.stem for p in (report / "figures").glob("*.svg")}
    scan = {f"budget_0_scan_{kind}" for kind in ("map", "campbell", "waterfall", "rates", "envelope", "line_of_sight")}
    own = {"budget_1_slew_envelope", "budget_1_slew_line_of_sight", f"budget_{keys[2]}_course"}
    assert figures == scan | own | {"budget_requirements", "budget_shares", "budget_coupling"}
    assert figures == {p.stem for p in (report / "figures").glob("*.png")}
    assert "\\<img src=x" in (report / "budget.md").read_text(encoding="utf-8")


def test_a_budget_without_requirements_or_modes_to_join(data, write_report, tmp_path):
    """A response is one-way only, its driving point may be unknown; the page is made all the same."""
    changed = copy.deepcopy(data) | {"requirements": [], "crossings": [], "named_modes": data["named_modes"][:1]}
    changed["coupling"] |= {"loop_gain": [None] * 500, "largest_at_lines": None}
    for mode in changed["modes"]:
        mode["line_of_sight_rms_two_way_rad"] = None
        mode["avoid"] = {}
    scan = changed["modes"][0]
    none = {"levels_rad": {}, "levels_ci95_rad": {}}
    scan["over_rate"] |= {"rms_two_way_rad": None, **none, "decided": {"coupling": "one-way", **none}}
    scan["lines"]["line_of_sight_two_way_rad"] = None
    write_report(changed, tmp_path)
    text = (tmp_path / "budget.html").read_text(encoding="utf-8")
    assert "No requirement is given" in text
    assert "one-way alone" in text


def test_verdicts_on_the_emission_are_shown(data):
    """Truth: the row; each printer has it, and its figure where it has several rates."""
    worst = {"value": 0.1, "upper": 0.2, "lower": 0.0, "limit": 0.5}
    words = {"rate": "46", "frequency": "92", "value": "0.1", "bounds": "0 to 0.2", "limit": "0.5", "margin": "+14.0"}
    row = {
        "name": "exported",
        "direction": "torque",
        "unit": "N*m",
        "verdict": "pass",
        "worst": {**worst, "rate": 46.0},
        "at_rates": [{"stepping": "scan", "rate": rate, "worst": worst} for rate in (46.0, 47.0)],
        "text": {**words, "mode": "scan", "verdict": "pass"},
    }
    changed = {**data, "emission_requirements": [row]}
    console = Console(width=200, file=io.StringIO())
    PRESENTER.print(changed, console)
    assert re.search(r"exported +torque +scan +46 +92", console.file.getvalue())
    assert "exported, torque, 46 steps/s, 92 Hz: pass; margin +14.0 dB" in console.file.getvalue()
    names = [name for name, _ in itertools.islice(budget_figures(changed), 3)]
    assert names == ["budget_requirements", "budget_shares", "budget_emission_1"]


@pytest.fixture(scope="module")
def browser():
    with chromium() as opened:
        yield opened


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("width", [1400, 390])
def test_the_page_opens_without_network_or_error_and_without_overflow(browser, report, width, dark):
    page = report / "budget.html"
    shown(browser, page, width, dark=dark)
    assert requests(browser) == [page.as_uri()]
    assert faults(browser) == []
    assert browser.title == "budget.toml · mechid budget"
    assert browser.execute_script("return document.documentElement.scrollWidth") <= width
    table = "const t = document.querySelector('#requirements ~ .scroll'); return [t.scrollWidth, t.clientWidth, "
    wide, room, first = browser.execute_script(table + "t.querySelector('tbody tr').cells[0].textContent]")
    assert wide <= room
    assert first in ("met", "not sure", "exceeded")


def test_the_page_shows_the_numbers_of_the_dict(browser, report, data):
    shown(browser, report / "budget.html", 1400)
    text = " ".join(browser.find_element("tag name", "body").text.split())
    for row in add_texts(data)["requirements"]:
        for key in (
            "index",
            "level",
            "limit",
            "one_way_margin",
            "two_way_margin",
            "deciding",
            "met",
            "two_way",
            "ecss",
        ):
            assert row["text"][key] in text
        assert f"(± {row['text']['sampling']} by draws)" in text
    for c in data["crossings"]:
        assert f"{c['rate']:.4g} {c['order']:g} {c['mode']}" in text
    assert HOSTILE in text


def test_the_page_shows_in_bold_the_margin_that_decides(browser, report, data):
    """Truth: the weight of the type that the browser draws; of a row's numbers the deciding one alone is bold."""
    shown(browser, report / "budget.html", 1400)
    bold = browser.execute_script(
        "return [...document.querySelector('#requirements ~ .scroll table').tBodies[0].rows].map((row) => "
        "[...row.cells].slice(1).filter((c) => getComputedStyle(c).fontWeight >= 600)"
        ".map((c) => c.innerText.split('\\n')[0]))"
    )
    rows = add_texts(data)["requirements"]
    assert bold == [[r["text"]["deciding"]] for r in rows]


def test_figures_take_the_colours_of_the_page_and_print(browser, report):
    shown(browser, report / "budget.html", 1400)
    ink = "return getComputedStyle(document.querySelector('#figure-budget_requirements svg text')).fill"
    light = browser.execute_script(ink)
    browser.find_element("id", "theme").click()
    assert browser.execute_script(ink) != light
    drawn = browser.execute_script("return [...document.querySelectorAll('.ink svg')].map((s) => s.clientWidth)")
    assert len(drawn) == 12
    assert min(drawn) > 300
    pdf = printed_to_pdf(browser)
    assert 4 <= len(re.findall(rb"/Type\s*/Page\b", pdf)) <= 20
