"""The report in a real browser. Truth: the records themselves, and what a page that needs nothing may not do."""

import json
import re

import numpy as np
import pytest

from browser import chromium, faults, printed_to_pdf, requests, shown, waited
from mechid.analysis.prediction import predict
from mechid.reports import outline
from mechid.reports.curves import record_curves
from mechid.reports.files import write_report
from mechid.reports.outline import decode_outline
from mechid.reports.trace import decode
from mechid.signal import stored_series
from mechid.signal.envelope import envelope

LABELS = {
    "torque": {"time, s", "torque, N m", "residual, N m"},
    "spectrum": {"frequency, Hz", "amplitude, N m"},
    "density": {"frequency, Hz", "residual density, N m/√Hz"},
    "correlation": {"lag, samples", "autocorrelation"},
    "spectrogram": {"time, s", "measured: frequency, Hz", "modelled: frequency, Hz"},
}
LABELS_SHOWN = """
return [...document.querySelectorAll('.figure[data-kind]')].map((target) => {
  const models = [...mechid.documents.get(target).root.references()];
  return [target.dataset.kind, models.filter((m) => m.type.endsWith('Axis')).map((m) => m.axis_label)];
});"""
SOURCE = """
const target = document.getElementById('torque-full_46'), shown = mechid.documents.get(target);
const source = (name) => { const d = shown.model(name + ' data').data; return [Array.from(d.x), Array.from(d.y)]; };
const frame = () => new Promise((done) => requestAnimationFrame(() => setTimeout(done, 50)));
"""


@pytest.fixture(scope="module")
def browser():
    with chromium() as opened:
        yield opened


@pytest.fixture(scope="module")
def page(reported):
    return reported.folder / "report.html"


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("width", [1400, 390])
def test_it_opens_without_network_or_console_error_and_without_overflow(browser, page, width, dark):
    shown(browser, page, width, dark=dark)
    assert requests(browser) == [page.as_uri()]
    assert faults(browser) == []
    assert browser.execute_script("return document.documentElement.scrollWidth") <= width
    wide = "return [...document.querySelectorAll('.figure')].filter((f) => f.scrollWidth > f.clientWidth + 1).length"
    assert browser.execute_script(wide) == 0


@pytest.mark.parametrize("width", [1400, 1180])
def test_parameters_and_records_are_whole_on_a_wide_screen(browser, page, width):
    """Truth: a table that is wider than its place hides its last column."""
    shown(browser, page, width)
    cut = """return [...document.querySelectorAll('.scroll:has(> .cards)')]
        .filter((place) => place.scrollWidth > place.clientWidth).length"""
    assert browser.execute_script(cut) == 0


@pytest.fixture(scope="module")
def opened(browser, page):
    """Return the browser with the page open and all figures drawn, on a wide screen."""
    shown(browser, page, 1400)
    return browser


def test_figures_carry_axis_labels_with_units(opened):
    found = opened.execute_script(LABELS_SHOWN)
    assert {kind for kind, _ in found} == set(LABELS)
    for kind, labels in found:
        assert set(labels) == LABELS[kind]


def test_every_sample_of_the_record_is_in_the_page(opened, reported):
    """Truth: the record as it was read; a sample may be off by a twentieth of its noise."""
    script = "const s = await mechid.records.get('full_46').samples(); return [[...s.measured], [...s.modelled]];"
    measured, modelled = map(np.array, waited(opened, script))
    (curves,) = record_curves(reported.campaign, reported.fit, reported.validation["full_46"])
    noise = reported.fit.records["full_46"].noise_sigma
    removed = curves.trace.offset + curves.trace.drift * np.arange(measured.size)
    truth = predict(reported.campaign.record("full_46"), reported.fit)["torque"]
    assert np.abs(measured + removed - truth.measured).max() <= 0.0501 * noise
    assert np.abs(modelled - truth.modelled).max() <= 0.0501 * noise
    assert [measured.tolist(), modelled.tolist()] == [d.tolist() for d in decode(curves.trace)]


def test_a_zoom_shows_every_sample_and_the_whole_its_extremes(opened, reported):
    """Truth: the Python twins of the script, `decode` and `envelope`."""
    (curves,) = record_curves(reported.campaign, reported.fit, reported.validation["full_46"])
    measured = decode(curves.trace)[0]
    columns = waited(opened, SOURCE + "return shown.width()")
    x, y = waited(opened, SOURCE + "return source('measured')")
    kept = envelope(measured, columns)
    assert len(kept) < measured.size / 1.1 or measured.size <= 4 * columns
    assert (np.round(np.array(x) * 1e4).astype(int).tolist(), y) == (kept.tolist(), measured[kept].tolist())
    x, y = waited(opened, SOURCE + "mechid.zoomed(shown, 0.1, 0.101); await frame(); return source('measured')")
    inside = [value for time, value in zip(x, y, strict=True) if 0.1 - 1e-9 <= time <= 0.101 + 1e-9]
    assert inside == measured[1000:1011].tolist()
    assert waited(opened, SOURCE + "return shown.model('measured samples').visible") is True


def test_a_long_record_is_decimated_as_its_twin_does(opened):
    """Truth: `envelope` on 600 001 samples."""
    seen = waited(
        opened,
        "const y = Float64Array.from({length: 600001}, (_, i) => Math.sin(i * i * 1e-7) + 1e-3 * (i % 7));"
        "return mechid.envelope(y, 0, y.length, 1000);",
    )
    i = np.arange(600_001.0)
    assert seen == envelope(np.sin(i * i * 1e-7) + 1e-3 * (i % 7), 1000).tolist()


def test_the_buttons_show_their_stretch(opened):
    buttons = opened.find_elements("css selector", "button[data-figure='torque-full_46']")
    assert [b.text for b in buttons] == ["whole record", "start", "largest torque", "single samples"]
    opened.execute_script("arguments[0].click()", buttons[3])
    range_now = SOURCE + "await frame(); const t = shown.model('time'); return [t.start, t.end];"
    expected = [float(buttons[3].get_attribute(f"data-{end}")) for end in ("from", "to")]
    assert waited(opened, range_now) == expected


def test_hostile_names_show_as_text(opened, reported):
    title = reported.campaign.path.parent.name
    assert opened.find_element("tag name", "h1").text.split() == title.split()
    assert opened.title.startswith("<img src=x")


def test_the_theme_can_be_switched(opened):
    colour = "return getComputedStyle(document.body).backgroundColor"
    before = opened.execute_script(colour)
    opened.find_element("id", "theme").click()
    assert opened.execute_script(colour) != before
    ink = SOURCE + "return [...shown.root.references()].find((m) => m.type === 'LinearAxis').axis_label_text_color"
    assert waited(opened, ink) == "#e8eaed"


def test_it_prints_with_its_figures_and_without_what_only_a_screen_has(opened):
    opened.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    seen = "return [...document.querySelectorAll(arguments[0])].map((e) => getComputedStyle(e).display)"
    assert set(opened.execute_script(seen, ".figure, .zooms, nav, #theme")) == {"none"}
    pictures = opened.execute_script("return [...document.querySelectorAll('img.paper')].map((i) => i.naturalWidth)")
    assert len(pictures) == 7
    assert all(width > 0 for width in pictures)
    pdf = printed_to_pdf(opened)
    opened.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
    assert pdf.startswith(b"%PDF")
    assert 4 <= len(re.findall(rb"/Type\s*/Page\b", pdf)) <= 20


def test_the_numbers_of_the_page_are_those_of_the_dict(opened, reported):
    data = json.loads((reported.folder / "report.json").read_text())
    text = " ".join(opened.find_element("tag name", "body").text.split())
    for row in data["parameters"]:
        if row["estimated"]:
            assert all(row["text"][key] in text for key in ("nominal", "estimate", "std_error", "unit", "min", "max"))
    for question in data["summary"]["questions"]:
        assert all(" ".join(answer.split()) in text for answer in question["answers"])


def test_the_dot_of_a_rate_stands_over_its_letter_and_the_index_below(opened):
    """Truth: where the browser has put them."""
    boxes = opened.execute_script("""
    const box = (e) => { const b = e.getBoundingClientRect(); return [b.left, b.right, b.top, b.bottom]; };
    return [...document.querySelectorAll('.equations msub > mover')].map((over) =>
      [over.firstElementChild, over.lastElementChild, over.parentElement.lastElementChild].map(box));""")
    assert boxes
    for letter, dot, index in boxes:
        assert letter[0] <= 0.5 * (dot[0] + dot[1]) <= letter[1]
        assert dot[3] <= letter[3]
        assert index[0] >= letter[1] - 1.0
        assert index[3] > letter[3]


@pytest.fixture(scope="module")
def long_page(reported, tmp_path_factory):
    """Return the curves and the page of the same records where 5000 samples are a long record."""
    with pytest.MonkeyPatch.context() as changes:
        changes.setattr(stored_series, "MAX_IN_MEMORY", 5000)
        changes.setattr(outline, "COLUMNS", 500)
        changes.setattr(outline, "DETAIL_S", 0.2)
        (curves,) = record_curves(reported.campaign, reported.fit, reported.validation["sweep"])
        folder = tmp_path_factory.mktemp("long")
        write_report(reported.data, reported.campaign, reported.fit, reported.validation, folder)
    return curves, folder / "report.html"


def test_a_long_record_shows_its_outline_and_every_sample_of_named_stretches(browser, long_page):
    """Truth: the Python twins, of 20 001 samples taken for a long record."""
    curves, page = long_page
    shown(browser, page, 1400)
    assert faults(browser) == []
    source = SOURCE.replace("torque-full_46", "torque-sweep")
    for name in ("measured", "modelled", "residual"):
        x, y = waited(browser, source + f"return source('{name}')")
        times, values = decode_outline(curves.trace, name)
        np.testing.assert_allclose(x, times, rtol=1e-12)
        np.testing.assert_allclose(y, values, rtol=1e-12)
    assert set(curves.trace.stretches) == {"start", "largest", "least followed"}
    trace = curves.trace.stretches["largest"]
    from_s, to_s = trace.start_s + 0.1, trace.start_s + 0.101
    zoom = f"mechid.zoomed(shown, {from_s}, {to_s}); await frame(); return source('measured')"
    x, y = waited(browser, source + zoom)
    inside = [value for time, value in zip(x, y, strict=True) if from_s - 1e-9 <= time <= to_s + 1e-9]
    assert inside == decode(trace)[0][1000:1011].tolist()
    buttons = browser.find_elements("css selector", "button[data-figure='torque-sweep']")
    assert [b.text for b in buttons][-1] == "least followed"
    assert "every 0.004 s" in browser.find_element("css selector", "section:has(> #record-sweep)").text
