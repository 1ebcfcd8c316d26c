"""The report of a budget: its verdict from the dict of numbers, its page in a real browser."""

import copy
import io
import json
import re
from dataclasses import replace

import numpy as np
import pytest
from rich.console import Console

from browser import chromium, faults, printed_to_pdf, requests, shown
from colours_drawn import wrong_colours
from mechid.budgets.budget import _with_deciding, make_budget
from mechid.budgets.budget_file import read_budget_file
from mechid.budgets.example import BUDGET, write_example
from mechid.budgets.margins import margins
from mechid.budgets.numbers import budget_data
from mechid.budgets.standing import nominal_level
from mechid.identification.result.estimate_file import json_text
from mechid.reports.budget.contents import budget_contents
from mechid.reports.budget.figures import budget_figures
from mechid.reports.budget.files import write_budget_report
from mechid.reports.budget.terminal import print_budget
from mechid.reports.budget.verdict import budget_verdict
from paper_estimate import write_estimate_of_paper

HOSTILE = "<img src=x onerror=document.title='taken'>"
SMALL = (
    BUDGET.replace("{ from = 10.0, to = 60.0, count = 26 }", "{ from = 44.0, to = 50.0, count = 4 }")
    .replace("[[0.0, 0.0], [6.0, 60.0], [8.0, 60.0], [10.0, 0.0]]", "[[0.0, 0.0], [2.0, 60.0]]")
    .replace('name = "run up"', f'name = "{HOSTILE}"')
)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("budget")
    write_estimate_of_paper(folder, fit_percent=99.0)
    write_example(folder)
    (folder / "budget.toml").write_text(SMALL, encoding="utf-8")
    return make_budget(read_budget_file(folder / "budget.toml"))


@pytest.fixture(scope="module")
def data(made):
    return json.loads(json_text(budget_data(made)))


@pytest.fixture(scope="module")
def folder(data, tmp_path_factory):
    out = tmp_path_factory.mktemp("report")
    write_budget_report(data, out)
    return out


def test_rates_are_added_at_crossings(data):
    """Truth: order 1 meets the structure's 47.5 Hz at 47.5 steps/s, which the range of four rates passes over."""
    scan = data["modes"][0]
    assert 47.5 in scan["rates"]
    assert scan["worst_rate"] == 47.5
    assert any(low < 47.5 < high for low, high in scan["avoid"]["stability in an exposure"])


def test_the_two_way_margin_decides_where_it_was_worked_out(data, made):
    """Truth: the joined model leaves nothing out, and the ratio of the nominal unit's levels; else one-way decides."""
    for row in data["requirements"]:
        ratio = row["two_way_rad"] / row["nominal_rad"]
        assert row["decided"]["coupling"] == "two-way"
        assert row["decided"]["margin"] == pytest.approx(1.0 - ratio * row["level_rad"] / row["limit_rad"])
    slew = made.modes[1].standings[0]
    assert margins(slew, None)["two_way"] is None
    assert margins(slew, None)["decided"] == {
        "coupling": "one-way",
        "level_rad": slew.level.value,
        "sigma_rad": slew.level.sigma,
        "sampling_sigma_rad": slew.sampling_rad,
        "residual_rad": slew.residual_rad,
        "margin": pytest.approx(slew.margin),
        "margin95": pytest.approx(list(slew.margin95)),
        "met": slew.margin95[0] >= 0.0,
    }
    by_duty = data["requirements"][-1]
    assert (by_duty["mode"], by_duty["decided"]["coupling"]) == ("all modes, by duty", "two-way")


def test_levels_over_the_rate_and_rates_to_avoid_are_those_of_the_margin_that_decides(data, made):
    """Truth: the rule, and the two-way responses. The curve peaks at the level and the band that decide."""
    scan, over = data["modes"][0], data["modes"][0]["over_rate"]
    assert over["decided"]["coupling"] == "two-way"
    for row in data["requirements"][:2]:
        name, decided = row["requirement"], row["decided"]
        levels = np.array(over["decided"]["levels_rad"][name])
        assert levels.max() == pytest.approx(decided["level_rad"])
        assert scan["rates"][int(levels.argmax())] == decided["at_rate"]
        nominal = [
            nominal_level(made.file.requirements[0], [(1.0, r)], made.file.errors) for r in made.modes[0].two_way
        ]
        if name == made.file.requirements[0].name:
            np.testing.assert_allclose(levels / levels.max(), np.array(nominal) / max(nominal))
        high = np.array(over["decided"]["levels_ci95_rad"][name])[:, 1]
        assert high[int(levels.argmax())] == pytest.approx(row["limit_rad"] * (1.0 - decided["margin95"][0]))
        assert decided["met"] == (not scan["avoid"][name]) == bool(np.all(high <= row["limit_rad"]))


def test_a_requirement_that_only_one_way_exceeds_has_no_rates_to_avoid(made):
    """Truth: the two levels. At a limit between the two-way and the one-way level nothing is to be avoided."""
    mode = made.modes[0]
    s = mode.standings[0]
    two_way = mode.two_way_levels[s.requirement.name][1] / s.nominal_rad * s.level.ci95[1]
    limit = 0.5 * (two_way + s.level.value)
    assert two_way < limit < s.level.value
    other = replace(s, requirement=replace(s.requirement, limit_rad=limit))
    assert _with_deciding(replace(mode, standings=(other,))).avoid[s.requirement.name] == ()
    one_way = replace(mode, standings=(other,), two_way_curves={}, two_way_levels={})
    assert _with_deciding(one_way).avoid[s.requirement.name] != ()


def test_one_number_decides_what_is_met(data):
    """Truth: the rule. The lower 95 % limit of the margin of the coupling that decides, and no other number."""
    for row in data["requirements"]:
        margin = row["two_way"] if row["decided"]["coupling"] == "two-way" else row
        assert row["decided"]["margin95"] == pytest.approx(margin["margin95"])
        assert row["met"] == row["decided"]["met"] == (row["decided"]["margin95"][0] >= 0.0)
    shown = [row["text"]["deciding"] for row in budget_contents(data)["requirements"]]
    assert shown == [f"{100.0 * row['decided']['margin95'][0]:.1f}" for row in data["requirements"]]


def test_the_sampling_error_of_the_ensemble_is_part_of_the_band(data):
    """Truth: the band's variance, of which it has its share."""
    for row in data["requirements"]:
        share = row["variance_shares"]["draws of the ensemble"]
        assert row["sampling_sigma_rad"] == pytest.approx(row["sigma_rad"] * np.sqrt(share), rel=1e-6)
        assert row["worst_member_share"] == (0.99865 if row["interpretation"] == "temporal" else None)
    assert any(row["sampling_sigma_rad"] > 0.0 for row in data["requirements"])


def test_the_tables_of_terminal_and_markdown_print_in_bold_what_decides(data, folder):
    """Truth: the dict's own numbers; rows in the dict's order."""
    deciding = [row["text"]["deciding"] for row in budget_contents(data)["requirements"]]
    text = (folder / "budget.md").read_text(encoding="utf-8")
    table = text.split("## Requirements")[1].split("##")[0]
    assert re.findall(r"[*][*](.*?)[*][*]", table) == deciding
    console = Console(width=300, force_terminal=True, file=io.StringIO())
    print_budget(data, console)
    rows = re.findall(r"^(?:met|not sure|exceeded) .*$", console.file.getvalue(), re.MULTILINE)
    bold = [re.findall(r"\x1b\[1m *([-0-9.]+)\x1b", row) for row in rows]
    assert bold == [[one] for one in deciding]


def test_the_figures_bar_is_the_level_that_decides(data):
    """Truth: the dict's own numbers, as shares of the limit; the margin that does not decide is marked beside."""
    (axes,) = budget_figures(budget_contents(data))["budget_requirements"].axes
    widths = [patch.get_width() for patch in axes.patches]
    assert widths == pytest.approx([r["decided"]["level_rad"] / r["limit_rad"] for r in data["requirements"]])
    marks = {line.get_label(): line for line in axes.lines}
    row = data["requirements"][0]
    assert marks["one-way, does not decide"].get_xdata()[0] == pytest.approx(row["level_rad"] / row["limit_rad"])


def test_shares_and_cumulative_rms_add_up(data):
    """Truth: shares are parts of a whole; all lines together are the RMS."""
    for row in data["requirements"]:
        assert sum(row["variance_shares"].values()) == pytest.approx(1.0)
        assert sum(row["spread_shares"].values()) == pytest.approx(1.0)
    for mode in data["modes"][:2]:
        assert [column[-1] for column in mode["cumulative_rms_rad"]["lines"]] == pytest.approx(
            mode["line_of_sight_rms_rad"]
        )


def test_the_map_holds_the_lines_and_the_envelope_its_largest(made, data):
    """Truth: the steady states themselves."""
    scan = data["modes"][0]
    lines = np.abs(made.modes[0].responses[1].state.lines)
    np.testing.assert_allclose(scan["map"]["torque_amplitude_Nm"][1][: lines.size], lines, rtol=1e-5)
    largest = max(abs(line) for r in made.modes[0].responses for line in r.state.lines)
    top = max(scan["envelope"]["bands"], key=lambda band: band["torque_amplitude_Nm"])
    assert top["torque_amplitude_Nm"] == pytest.approx(largest)
    assert top["ci95_Nm"][0] < largest < top["ci95_Nm"][1]


def test_no_legend_lies_over_curves(data):
    """Truth: the places of legends and axes as Matplotlib draws them."""
    for name, figure in budget_figures(budget_contents(data)).items():
        figure.draw_without_rendering()
        axes = [a.get_window_extent() for a in figure.axes]
        legends = [*figure.legends, *(a.get_legend() for a in figure.axes if a.get_legend())]
        boxes = [(b.x0 + 1, b.y0 + 1, b.x1 - 1, b.y1 - 1) for b in (legend.get_window_extent() for legend in legends)]
        over = [1 for x0, y0, x1, y1 in boxes for a in axes if x0 < a.x1 and x1 > a.x0 and y0 < a.y1 and y1 > a.y0]
        assert not over, name


def test_colours_mean_what_they_mean_elsewhere(data):
    """Truth: the one table of colours."""
    figures = budget_figures(budget_contents(data))
    assert [line for figure in figures.values() for line in wrong_colours(figure)] == []


@pytest.mark.parametrize("is_so", [True, False])
def test_terminal_page_and_markdown_say_that_records_were_simulated(data, tmp_path, is_so):
    """Truth: what the estimate says."""
    changed = {**data, "synthetic": is_so}
    console = Console(width=200, file=io.StringIO())
    print_budget(changed, console)
    write_budget_report(changed, tmp_path)
    said = [(tmp_path / name).read_text(encoding="utf-8") for name in ("budget.html", "budget.md")]
    for text in (console.file.getvalue(), *said):
        assert ("records were simulated" in text) == is_so


def test_only_shares_that_can_be_seen_are_named(data):
    """Truth: the shares themselves."""
    figure = budget_figures(budget_contents(data))["budget_shares"]
    named = {text.get_text() for text in figure.legends[0].get_texts()} - {"all others"}
    largest = {n: max(r["variance_shares"].get(n, 0.0) for r in data["requirements"]) for n in named}
    assert named
    assert min(largest.values()) >= 0.01


@pytest.mark.parametrize(
    ("margins", "warnings", "grade"),
    [((0.5, 0.4), [], "good"), ((0.5, -0.1), [], "caution"), ((-0.1, -0.2), [], "bad"), ((0.5, 0.4), ["w"], "caution")],
)
def test_the_grade(data, margins, warnings, grade):
    """Truth: the rule. Good where every band is within its limit and nothing is odd, bad where a value is beyond."""
    changed = {**copy.deepcopy(data), "warnings": warnings}
    for row in changed["requirements"]:
        row["decided"] |= {"margin": margins[0], "margin95": [margins[1], 0.9], "met": margins[1] >= 0.0}
    assert budget_verdict(changed)["grade"] == grade


def test_the_verdict_tells_rates_drivers_and_coupling(data):
    """Truth: the dict's own numbers."""
    met, drives, worst, coupling = (q["answers"] for q in budget_verdict(data)["questions"])
    least = min(data["requirements"], key=lambda r: r["decided"]["margin95"][0])
    assert met[0].startswith(f"{least['requirement']}, {least['mode']}")
    assert f"{100.0 * least['decided']['margin']:.1f} % of the limit" in met[0]
    assert next(iter(least["variance_shares"])) in drives[0]
    assert any(re.search(r"avoid 47[.]\d+ to 47[.]\d+ steps/s", line) for line in worst)
    assert "the two-way result decides" in coupling[0]
    scan = data["modes"][0]
    pairs = zip(scan["line_of_sight_rms_two_way_rad"], scan["line_of_sight_rms_rad"], strict=True)
    change = max((joined / held - 1.0 for joined, held in pairs), key=abs)
    assert any(f"scan: joined, the RMS changes by {100.0 * change:+.2g} %" in line for line in coupling)


def test_files(folder, data):
    names = {p.name for p in folder.iterdir()}
    assert names == {"budget.html", "budget.md", "figures"}
    keys = [mode["key"] for mode in budget_contents(data)["modes"]]
    assert keys == ["0_scan", "1_slew", "2_img_src_x_onerror_document_title_taken"]
    figures = {p.stem for p in (folder / "figures").glob("*.svg")}
    scan = {f"budget_0_scan_{kind}" for kind in ("map", "campbell", "waterfall", "rates", "envelope", "line_of_sight")}
    own = {"budget_1_slew_envelope", "budget_1_slew_line_of_sight", f"budget_{keys[2]}_course"}
    assert figures == scan | own | {"budget_requirements", "budget_shares", "budget_coupling"}
    assert figures == {p.stem for p in (folder / "figures").glob("*.png")}
    assert "\\<img src=x" in (folder / "budget.md").read_text(encoding="utf-8")


def test_a_budget_without_requirements_or_modes_to_join(data, tmp_path):
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
    write_budget_report(changed, tmp_path)
    text = (tmp_path / "budget.html").read_text(encoding="utf-8")
    assert "No requirement is given" in text
    assert "one-way alone" in text


@pytest.fixture(scope="module")
def browser():
    with chromium() as opened:
        yield opened


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("width", [1400, 390])
def test_the_page_opens_without_network_or_error_and_without_overflow(browser, folder, width, dark):
    page = folder / "budget.html"
    shown(browser, page, width, dark=dark)
    assert requests(browser) == [page.as_uri()]
    assert faults(browser) == []
    assert browser.title == "budget.toml · mechid budget"
    assert browser.execute_script("return document.documentElement.scrollWidth") <= width
    table = "const t = document.querySelector('#requirements ~ .scroll'); return [t.scrollWidth, t.clientWidth, "
    wide, room, first = browser.execute_script(table + "t.querySelector('tbody tr').cells[0].textContent]")
    assert wide <= room
    assert first in ("met", "not sure", "exceeded")


def test_the_page_shows_the_numbers_of_the_dict(browser, folder, data):
    shown(browser, folder / "budget.html", 1400)
    text = " ".join(browser.find_element("tag name", "body").text.split())
    for row in budget_contents(data)["requirements"]:
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


def test_the_page_shows_in_bold_the_margin_that_decides(browser, folder, data):
    """Truth: the weight of the type that the browser draws; of a row's numbers the deciding one alone is bold."""
    shown(browser, folder / "budget.html", 1400)
    bold = browser.execute_script(
        "return [...document.querySelector('#requirements ~ .scroll table').tBodies[0].rows].map((row) => "
        "[...row.cells].slice(1).filter((c) => getComputedStyle(c).fontWeight >= 600)"
        ".map((c) => c.innerText.split('\\n')[0]))"
    )
    rows = budget_contents(data)["requirements"]
    assert bold == [[r["text"]["deciding"]] for r in rows]


def test_figures_take_the_colours_of_the_page_and_print(browser, folder):
    shown(browser, folder / "budget.html", 1400)
    ink = "return getComputedStyle(document.querySelector('#figure-requirements svg text')).fill"
    light = browser.execute_script(ink)
    browser.find_element("id", "theme").click()
    assert browser.execute_script(ink) != light
    drawn = browser.execute_script("return [...document.querySelectorAll('.ink svg')].map((s) => s.clientWidth)")
    assert len(drawn) == 12
    assert min(drawn) > 300
    pdf = printed_to_pdf(browser)
    assert 4 <= len(re.findall(rb"/Type\s*/Page\b", pdf)) <= 20
