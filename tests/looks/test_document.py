"""The document and files of a look. Truth: the dict of its numbers, and the rules for a page that stands alone."""

import csv
import json
import re

import numpy as np
import pytest

from browser import chromium, faults, requests, shown


def test_every_file_is_there_and_the_page_needs_nothing(looked):
    folder, stdout = looked
    assert {path.name for path in folder.iterdir()} == {"look.html", "look.md", "look.json", "csv", "figures"}
    page = (folder / "look.html").read_text()
    assert not re.search(r'(?:src|href)="(?!#|data:)', page)
    assert "written: " in stdout
    assert (folder / "figures" / "gapped_spectrum.png").stat().st_size > 5000


def test_the_terminal_and_the_csv_say_the_same_numbers(looked):
    folder, stdout = looked
    data = json.loads((folder / "look.json").read_text())
    for record in data["records"]:
        for channel in record["channels"]:
            assert all(line in stdout for lines in channel["words"].values() for line in lines)
    lines = [line for record in data["records"] for channel in record["channels"] for line in channel["lines"]]
    rows = list(csv.DictReader((folder / "csv" / "lines.csv").read_text().splitlines()))
    assert [float(row["amplitude"]) for row in rows] == pytest.approx([line["amplitude"] for line in lines])
    density = np.loadtxt(folder / "csv" / "gapped_density.csv", delimiter=",", skiprows=1)
    assert density.shape[1] == 2


def test_page_and_markdown_have_each_channel(looked):
    """Truth: the files: a record of two channels and one with a gap, whose hundreds of lines are on the page alone."""
    page, markdown = ((looked[0] / f"look.{suffix}").read_text() for suffix in ("html", "md"))
    assert markdown.startswith("# A look at 2 records\n")
    for key, heading in (("two.torque_Nm", "torque, N m"), ("two.ticks", "ticks"), ("gapped", "torque, N m")):
        assert f'<a href="#channel-{key}">' in page
        assert f'<h3 id="channel-{key}">{heading} (column ' in page
        assert f"### {heading} (column " in markdown
        assert f"(<figures/{key}_spectrum.svg>)" in markdown
    assert "lines of the spectrum" in page
    assert "lines of the spectrum" not in markdown


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("width", [1200, 390])
def test_the_page_in_a_browser_asks_for_nothing_and_complains_of_nothing(looked, width, dark):
    with chromium() as browser:
        shown(browser, looked[0] / "look.html", width, dark=dark)
        assert requests(browser) == [(looked[0] / "look.html").as_uri()]
        assert faults(browser) == []
        assert browser.execute_script("return document.documentElement.scrollWidth") <= width
