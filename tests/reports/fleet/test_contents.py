"""The report of a fleet: its texts from the dict of numbers, its page in a real browser."""

import io
import json

import numpy as np
import pytest
from matplotlib.collections import Collection
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from rich.console import Console

import mechid
from browser import chromium, faults, requests, shown
from colours_drawn import SAID, colours_of, wrong_colours
from estimates import free
from mechid.fleets.numbers import fleet_data
from mechid.reports.fleet.contents import fleet_contents
from mechid.reports.fleet.figures import fleet_figures
from mechid.reports.fleet.files import write_fleet_report
from mechid.reports.fleet.terminal import print_fleet
from mechid.reports.fleet.verdict import fleet_verdict
from synthetic_fleet import Truth, quoted, write_fit, write_fleet_file

HOSTILE = "<img src=x onerror=document.title='taken'>"


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """Return the numbers of 8 units over temperature, before and after, in two lots; one stands off, one has failed."""
    folder, rng, entries = tmp_path_factory.mktemp("fleet"), np.random.default_rng(3), []
    truth = Truth(slopes={"friction.viscous": -0.004})
    for k in range(8):
        unit = truth.unit(rng)
        unit["gear.stiffness"] *= 0.6 if k == 5 else 1.0
        for state in ("before", "after"):
            if state == "after":
                unit["gear.damping"] *= 1.1
            values = truth.estimated(unit, rng, 5.0 * k)
            if k == 0:
                values["stepper.detent.0.amplitude"] = free(0.001, 1e-5, "N m")
            write_fit(folder / f"{k}{state}", values, grade="C" if k == 7 else "A")
            entries.append(
                {
                    "folder": quoted(f"{k}{state}"),
                    "label": quoted(f"FM{k} {HOSTILE if k == 1 else ''} {state}"),
                    "unit": quoted(f"FM{k}"),
                    "state": quoted(state),
                    "group": quoted("AB"[k % 2]),
                    "covariates": f"{{ temperature_degC = {5.0 * k}, date = 2026-01-{1 + k:02d} }}",
                }
            )
    file = write_fleet_file(folder, entries, 'before_after = [["before", "after"]]')
    return fleet_data(mechid.fleet(file, out=folder / "out"), folder / "out")


def answers(data, words):
    return next(q["answers"] for q in fleet_verdict(data)["questions"] if words in q["question"])


def test_the_verdict_says_what_the_numbers_say(data):
    verdict = fleet_verdict(data)
    assert verdict["tone"] == "bad"
    assert verdict["headline"].startswith("2 of 16 campaigns of 8 units have no estimate to use")
    assert any(line.startswith("FM5: gear.stiffness") for line in answers(data, "stand off"))
    assert answers(data, "go with")[0].startswith("friction.viscous: ")
    assert any(line.startswith("gear.damping: ") and "mean of 7 units" in line for line in answers(data, "changed"))


def test_terms_that_only_some_have_are_said_to_have_no_mean(data):
    row = next(p for p in fleet_contents(data)["parameters"] if p["name"] == "stepper.detent.0.amplitude")
    assert (row["text"]["mean"], row["text"]["lacking"]) == ("–", "14 of 16 have no such")
    assert [cell["text"] for cell in row["cells"]][:3] == ["0.001000", "0.001000", ""]


def test_the_terminal_shows_campaigns_and_parameters(data):
    stream = io.StringIO()
    print_fleet(data, Console(file=stream, width=160, legacy_windows=False, _environ={}))
    said = stream.getvalue()
    assert "FM5" in said
    assert "stands off" in said
    assert "caution: temperature_degC and date go together" in said


def test_the_page_stands_alone_in_a_browser(data, tmp_path):
    """No script of a label runs, nothing is asked for, nothing is wider than the screen, on a telephone too."""
    page, figures = write_fleet_report(json.loads(json.dumps(data)), tmp_path)
    assert {p.stem for p in figures.iterdir()} == {"fleet_parameters", "fleet_trends", "fleet_changes"}
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


def test_colours_mean_what_they_mean_elsewhere(data):
    """Truth: the one table of colours; what a fleet draws is neither measured nor modelled, residual or noise."""
    for _, figure in fleet_figures(fleet_contents(data)):
        assert wrong_colours(figure) == []
        drawn = {colour for axes in figure.axes for artist in axes.get_children() for colour in colours_if_any(artist)}
        assert drawn.isdisjoint(colour.lower() for colour in SAID)


def colours_if_any(artist):
    return colours_of(artist) if isinstance(artist, Line2D | Collection | Patch) else set()


def test_links_lead_to_reports_after_the_whole_was_moved(tmp_path):
    """Truth: the file that the browser opens, of a unit within the fleet's folder and of one beside it."""
    drawn = np.random.default_rng(5)
    folders = [tmp_path / "here" / name for name in (ODD, "fleet/units/FM2", "FM3")]
    for folder in folders:
        folder.parent.mkdir(parents=True, exist_ok=True)
        write_fit(folder, Truth().estimated(Truth().unit(drawn), drawn, 0.0))
        (folder / "report.html").write_text(f"<title>{folder.name.replace('%', '')}</title>", encoding="utf-8")
    out = tmp_path / "here" / "fleet"
    write_fleet_report(fleet_data(mechid.fleet(*folders, out=out), out), out)
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
    page = write_fleet_report(data, tmp_path / "out")[0].read_text(encoding="utf-8")
    assert "<a href=" not in page.split('id="campaigns"')[1].split("</table>")[0]
    assert "FM1" in page
