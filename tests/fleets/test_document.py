"""The document of a fleet: its verdict and tables from the dict of numbers, its page in a real browser."""

import json

import numpy as np

import mechid
from browser import chromium, faults, requests, shown
from mechid.fleets.document import PRESENTER
from mechid.fleets.figures import figure_names
from mechid.fleets.numbers import fleet_data
from mechid.fleets.texts import fleet_texts
from mechid.fleets.verdict import fleet_verdict
from printing import printed
from synthetic_fleet import Truth, write_fit


def answers(data, words):
    return next(lines for question, lines in fleet_verdict(data).questions if words in question)


def test_the_verdict_says_what_the_numbers_say(data):
    verdict = fleet_verdict(data)
    assert verdict.tone == "bad"
    assert verdict.headline.startswith("2 of 16 campaigns of 8 units have no estimate to use")
    assert any(line.startswith("FM5: gear.stiffness") for line in answers(data, "stand off"))
    assert answers(data, "go with")[0].startswith("friction.viscous: ")
    assert any(line.startswith("gear.damping: ") and "mean of 7 units" in line for line in answers(data, "changed"))


def test_the_terminal_shows_campaigns_and_parameters(data):
    said = printed(PRESENTER.print, data, 160)
    assert "FM5" in said
    assert "stands off" in said
    assert "caution: temperature_degC and date go together" in said


def test_the_page_stands_alone_in_a_browser(data, tmp_path):
    """No script of a label runs, nothing is asked for, nothing is wider than the screen, on a telephone too."""
    *_, page, figures = PRESENTER.write(None, json.loads(json.dumps(data)), tmp_path)
    assert {p.stem for p in figures.iterdir()} == {"fleet_parameters", "fleet_trends", "fleet_changes"}
    assert figure_names(fleet_texts(data)) == ["fleet_parameters", "fleet_trends", "fleet_changes"]
    with chromium() as browser:
        for width, dark in ((1200, False), (390, True)):
            shown(browser, page, width, dark=dark)
            assert browser.execute_script("return document.documentElement.scrollWidth") <= width
            assert browser.title == "16 campaigns · mechid fleet"
            assert len(browser.find_elements("css selector", ".ink svg")) == 3
            assert faults(browser) == []
            assert requests(browser) == [page.as_uri()]


ODD = "FM 1#2 50%"
"""A folder's name that is none of a link as it stands."""


def test_links_lead_to_reports_after_the_whole_was_moved(tmp_path):
    """Truth: the file that the browser opens, of a unit within the fleet's folder and of one beside it."""
    drawn = np.random.default_rng(5)
    folders = [tmp_path / "here" / name for name in (ODD, "fleet/units/FM2", "FM3")]
    for folder in folders:
        folder.parent.mkdir(parents=True, exist_ok=True)
        write_fit(folder, Truth().estimated(Truth().unit(drawn), drawn, 0.0))
        (folder / "report.html").write_text(f"<title>{folder.name.replace('%', '')}</title>", encoding="utf-8")
    out = tmp_path / "here" / "fleet"
    mechid.fleet(*folders, out=out).write(out)
    assert str(tmp_path) not in (out / "fleet.html").read_text(encoding="utf-8")
    (tmp_path / "here").rename(tmp_path / "moved")
    with chromium() as browser:
        page = tmp_path / "moved" / "fleet" / "fleet.html"
        for number, title in enumerate(("FM 1#2 50", "FM2", "FM3")):
            shown(browser, page, 1200)
            browser.find_elements("css selector", "#campaigns ~ .scroll a")[number].click()
            assert browser.title == title


def test_a_report_on_another_drive_is_named_without_a_link(tmp_path, monkeypatch):
    """Truth: Windows, where no relative path leads to another drive; `os.path.relpath` says so."""

    def other_drive(path, start):
        raise ValueError("path is on mount 'D:', start on mount 'C:'")

    drawn = np.random.default_rng(5)
    write_fit(tmp_path / "FM1", Truth().estimated(Truth().unit(drawn), drawn, 0.0))
    (tmp_path / "FM1" / "report.html").write_text("", encoding="utf-8")
    fleet = mechid.fleet(tmp_path / "FM1", out=tmp_path / "out")
    monkeypatch.setattr("mechid.fleets.numbers.os.path.relpath", other_drive)
    data = fleet_data(fleet, tmp_path / "out")
    assert data["campaigns"][0]["folder"] == str(tmp_path / "FM1")
    PRESENTER.write(None, data, tmp_path / "out")
    page = (tmp_path / "out" / "fleet.html").read_text(encoding="utf-8")
    assert "<a href=" not in page.split('id="campaigns"')[1].split("</table>")[0]
    assert "FM1" in page


def test_markdown_and_page_say_what_the_terminal_does(data, tmp_path):
    """Truth: the verdict; a label from a user's file is text in both; a value that is not counted says why."""
    PRESENTER.write(None, data, tmp_path)
    page, markdown = ((tmp_path / f"fleet.{suffix}").read_text(encoding="utf-8") for suffix in ("html", "md"))
    for text in (page, markdown, printed(PRESENTER.print, data, 160)):
        assert fleet_verdict(data).headline in text
    assert "<img" not in page
    assert "FM1 \\<img src=x" in markdown
    assert "grade C |" in markdown
    assert "that may be chance" in page
    assert "that may be chance" not in markdown
