"""The explorer in a real browser. Truth: the simulation at what is set, the mechanism behind the records, the files."""

import threading
import time
from urllib.parse import urlsplit

import numpy as np
import pytest

import synthetic
from browser import faults, requests
from diagnosis_folder import DETENT
from mechid.campaign import load_mechanism
from mechid.identification.computation.journal import Journal
from mechid.simulation.interruption import check_interruption
from mechid.web.figures import RESIDUAL_HEIGHT, TORQUE_HEIGHT
from mechid.web.session import Session

KNOB = "gear.stiffness"
SECONDS = 60.0
SOURCE = """
const root = Bokeh.documents[0].roots().find((r) => r.name === arguments[0]);
const source = [...root.references()].find((m) => m.type === 'ColumnDataSource' && 'modelled' in m.data);
const whole = (y) => Array.from(y).filter(Number.isFinite);
return Object.fromEntries(Object.entries(source.data).map(([name, y]) => [name, whole(y)]));"""


def until(browser, script, *arguments):
    """Wait until a script returns something that is true, and return it."""
    end = time.monotonic() + SECONDS
    while time.monotonic() < end:
        found = browser.execute_script(script, *arguments)
        if found:
            return found
        time.sleep(0.05)
    raise AssertionError(f"not within {SECONDS} s: {script}")


def idle(browser):
    until(browser, "return Boolean(window.mechid) && mechid.idle()")


def opened(browser, address, width=1400, *, dark=False):
    screen = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 500}
    scheme = [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": scheme})
    if browser.current_url.startswith("http"):
        browser.execute_script("sessionStorage.clear()")  # else the tab's session goes on
    browser.get_log("browser"), browser.get_log("performance")
    browser.get(address)
    idle(browser)


def asked(browser, **message):
    browser.execute_script("mechid.ask(arguments[0])", message)
    idle(browser)


def told(browser):
    return browser.execute_script("return mechid.state()")


TOOLBAR_PX = 40.0
SHIFT = 8
"""Of the browser's protocol."""


def pressed(browser, key, times, modifiers=0):
    """Press an arrow key on a knob's slider, as a hand would."""
    browser.execute_script("mechid.knobs.get(arguments[0]).querySelector('[type=range]').focus()", KNOB)
    for _ in range(times):
        for kind in ("keyDown", "keyUp"):
            event = {"type": kind, "key": key, "code": key, "modifiers": modifiers}
            browser.execute_cdp_cmd("Input.dispatchKeyEvent", event)
    idle(browser)


def dragged(browser, pixels, modifiers=0):
    """Drag a knob's slider from its middle, as a hand would."""
    box = browser.execute_script(
        "const range = mechid.knobs.get(arguments[0]).querySelector('[type=range]');"
        "range.scrollIntoView({ block: 'center' });"
        "const box = range.getBoundingClientRect(); return [box.x + box.width / 2, box.y + box.height / 2]",
        KNOB,
    )
    for kind, x in (("mousePressed", 0), ("mouseMoved", pixels), ("mouseReleased", pixels)):
        event = {"type": kind, "x": box[0] + x, "y": box[1], "button": "left", "clickCount": 1, "modifiers": modifiers}
        browser.execute_cdp_cmd("Input.dispatchMouseEvent", event)
    idle(browser)


@pytest.mark.parametrize(("width", "dark"), [(1400, False), (1400, True), (390, False)])
def test_it_opens_with_loopback_requests_alone_no_console_error_and_no_overflow(browser, address, width, dark):
    opened(browser, address, width, dark=dark)
    asked(browser, do="look", records=["full_46", "micro_46", "sweep"], seconds=1e9)
    assert {urlsplit(url).netloc for url in requests(browser)} == {urlsplit(address).netloc}
    assert faults(browser) == []
    assert browser.execute_script("return document.documentElement.scrollWidth") <= width
    shown = "return [...document.querySelectorAll('.panel:not([hidden]) h2')].map((h) => h.textContent)"
    assert browser.execute_script(shown) == ["full_46", "micro_46", "sweep"]
    uses = "return [...document.querySelectorAll('.chip .use')].map((u) => u.textContent)"
    assert browser.execute_script(uses) == ["", "", "held out"]
    wide = "return [...document.querySelectorAll('.figure')].filter((f) => f.scrollWidth > f.clientWidth + 1).length"
    assert browser.execute_script(wide) == 0


def test_figures_carry_axis_labels_with_units(browser, address):
    opened(browser, address)
    labels = browser.execute_script(
        "return Bokeh.documents[0].roots().flatMap((root) => [...root.references()])"
        ".filter((m) => m.type.endsWith('Axis')).map((m) => m.axis_label)"
    )
    units = {"time, s", "torque, N m", "residual, N m", "effect, N m", "frequency, Hz", "amplitude, N m"}
    assert units <= set(labels)


def test_a_slider_moves_the_curves_to_the_simulation_of_its_value(browser, address, source):
    opened(browser, address)
    before = browser.execute_script(SOURCE, "time_0")
    pressed(browser, "ArrowRight", 12)
    after = browser.execute_script(SOURCE, "time_0")
    value = told(browser)["knobs"][KNOB]["value"]
    assert value > source.campaign.mechanism.value(KNOB)
    twin = Session(source)
    twin.turn(KNOB, value)
    picture = twin.pictures()["full_46"]
    for name in ("measured", "modelled", "residual"):
        kept = np.round(np.array(after[f"{name} at"]) * synthetic.RATE_HZ).astype(int)
        assert after[name] == getattr(picture, name)[kept].tolist()
        assert (max(after[name]), min(after[name])) == (getattr(picture, name).max(), getattr(picture, name).min())
    assert after["modelled spectrum"] == picture.modelled_spectrum.tolist()
    assert before["modelled"] != after["modelled"]
    assert (
        dict(told(browser)["records"][0]["numbers"])["residual"] in browser.find_element("css selector", ".panel").text
    )
    assert len(browser.execute_script("return mechid.latencies")) > 0


IMAGES = """
const root = Bokeh.documents[0].roots().find((r) => r.name === "spectrogram_0");
const source = [...root.references()].find((m) => m.type === "ColumnDataSource" && "residual" in m.data);
const names = ["measured", "modelled", "residual"];
return Object.fromEntries(names.map((name) => [name, Array.from(source.data[name][0])]));"""


def test_a_drawing_leaves_style_sheets_alone_that_stay_as_they_are(browser, address):
    """Truth: writing a sheet puts another text into it, as a change of it does."""
    opened(browser, address)
    texts = """
    const { InlineStyleSheet } = Bokeh.require("core/dom");
    const sheet = new InlineStyleSheet("a { top: 0px }"), first = sheet.el.firstChild;
    sheet.replace("a { top: 0px }");
    const same = sheet.el.firstChild === first;
    sheet.replace("a { top: 1px }");
    return [same, sheet.el.firstChild === first, sheet.css];"""
    assert browser.execute_script(texts) == [True, False, "a { top: 1px }"]


def test_a_sweep_is_shown_over_time_and_frequency_and_follows_when_the_slider_rests(browser, address, source):
    opened(browser, address)
    hidden = "return document.querySelector('.sweep').hidden"
    assert browser.execute_script(hidden)
    asked(browser, do="look", records=["full_46", "sweep"], seconds=1e9)
    assert not browser.execute_script(hidden)
    before = browser.execute_script(IMAGES)
    pressed(browser, "ArrowRight", 12)
    after = browser.execute_script(IMAGES)
    twin = Session(source)
    twin.look(("sweep",), 1e9)
    twin.turn(KNOB, told(browser)["knobs"][KNOB]["value"])
    image = twin.sweeps(twin.pictures())["sweep"]
    for name, shown in after.items():
        assert shown == getattr(image, name).astype(np.float32).ravel().tolist()
    assert before["modelled"] != after["modelled"]
    said = browser.find_element("css selector", ".sweep").text
    assert f"load on the gear {image.resonances[0].frequency_hz:.1f} Hz" in said
    reach = "return Bokeh.documents[0].get_model_by_name('frequency_0').end"
    assert browser.execute_script(reach) == 250
    browser.find_elements("css selector", ".tops button")[1].click()
    assert browser.execute_script(reach) == 1100
    asked(browser, do="look", records=["full_46"], seconds=1.0)
    assert browser.execute_script(hidden)
    assert faults(browser) == []


@pytest.mark.slow
def test_a_zoom_shows_every_sample(browser, address, source):
    opened(browser, address)
    browser.execute_script(
        "const root = Bokeh.documents[0].roots().find((r) => r.name === 'time_0');"
        "[...root.references()].find((m) => m.type === 'Figure').x_range.setv({ start: 0.1, end: 0.11 })"
    )
    inside = "const x = (() => {" + SOURCE + "})(...arguments)['modelled at']; return x.length < 200 ? x : null"
    x = np.array(until(browser, inside, "time_0"))
    kept = np.round(x[(x >= 0.1 - 1e-9) & (x <= 0.11 + 1e-9)] * synthetic.RATE_HZ).astype(int)
    assert kept.tolist() == list(range(1000, 1101))


def test_a_slider_has_fine_steps_where_there_is_no_estimate(browser, address, campaign):
    """Truth: a notch is a 2000th of the logarithm between the file's bounds, and a fine step a hundredth of it."""
    opened(browser, address)
    limits, start = campaign.mechanism.parameters[KNOB], told(browser)["knobs"][KNOB]["value"]
    notch = np.log(limits.max / limits.min) / 2000.0
    pressed(browser, "ArrowRight", 5, SHIFT)
    fine = told(browser)["knobs"][KNOB]["value"]
    assert fine == pytest.approx(start * (1.0 + 0.05 * notch), rel=1e-7)
    pressed(browser, "ArrowLeft", 5, SHIFT)
    assert told(browser)["knobs"][KNOB]["value"] == pytest.approx(start, rel=1e-7)
    pressed(browser, "ArrowRight", 4)
    assert np.log(told(browser)["knobs"][KNOB]["value"] / start) == pytest.approx(4.0 * notch, abs=0.6 * notch)
    assert "hundredth of a notch" in browser.find_element("id", "hand").text
    assert "with Shift" in browser.find_element("tag name", "aside").text
    assert faults(browser) == []


def test_the_highlighted_button_is_the_search_until_the_sliders_have_left_the_catalogue(browser, address):
    opened(browser, address)
    strong = "return [...document.querySelectorAll('button.strong')].map((b) => b.textContent)"
    assert browser.execute_script(strong) == ["Search from scratch"]
    pressed(browser, "ArrowRight", 1)
    assert browser.execute_script(strong) == ["Fit from here"]
    browser.find_element("id", "file").click()
    idle(browser)
    assert browser.execute_script(strong) == ["Search from scratch"]


def test_undo_by_the_button_and_by_the_keyboard(browser, address):
    opened(browser, address)
    start = told(browser)["knobs"][KNOB]["value"]
    pressed(browser, "ArrowRight", 1)
    browser.find_element("id", "undo").click()
    idle(browser)
    assert told(browser)["knobs"][KNOB]["value"] == start
    pressed(browser, "ArrowLeft", 1)
    browser.execute_script("document.dispatchEvent(new KeyboardEvent('keydown', { key: 'z', ctrlKey: true }))")
    idle(browser)
    assert told(browser)["knobs"][KNOB]["value"] == start
    assert not browser.find_element("id", "undo").is_enabled()


def test_with_shift_a_key_or_a_pixel_is_a_tenth_of_a_sigma(browser, estimated):
    """Truth: the estimate's own value and standard error."""
    address, estimate = estimated
    opened(browser, address)
    value, sigma = estimate.values[KNOB], estimate.sigmas[KNOB]
    asked(browser, do="estimate")
    pressed(browser, "ArrowUp", 7, SHIFT)
    assert (told(browser)["knobs"][KNOB]["value"] - value) / sigma == pytest.approx(0.7)
    assert told(browser)["knobs"][KNOB]["away"] == "+0.7 σ"
    pressed(browser, "ArrowDown", 20, SHIFT)
    assert (told(browser)["knobs"][KNOB]["value"] - value) / sigma == pytest.approx(-1.3)
    dragged(browser, 25, SHIFT)
    assert (told(browser)["knobs"][KNOB]["value"] - value) / sigma == pytest.approx(1.2)
    browser.find_element("id", "undo").click()
    idle(browser)
    assert (told(browser)["knobs"][KNOB]["value"] - value) / sigma == pytest.approx(-1.3)
    dragged(browser, 25)
    assert abs(told(browser)["knobs"][KNOB]["value"] - value) / sigma > 10.0
    assert "(0.1 σ)" in browser.find_element("id", "hand").text
    assert faults(browser) == []


def test_fit_from_here_converges_and_is_shown_as_it_goes(browser, address):
    opened(browser, address)
    browser.find_element("id", "fit").click()
    until(browser, "return mechid.state().run?.state === 'finished' && mechid.state().verdict")
    idle(browser)
    state = told(browser)
    for name, true in {"gear.stiffness": 913.47, "gear.damping": 0.39}.items():
        text, error = state["knobs"][name]["estimate"].split(" ± ")
        assert abs(float(text) - true) < 4.0 * float(error)
    browser.find_element("css selector", "#said summary").click()
    text = browser.find_element("id", "answers").text
    for question in ("Is this fit good?", "What is least certain?", "What would improve it?"):
        assert question in text
    assert "gear.damping" in text
    assert "No larger than the noise." in browser.find_element("css selector", ".panel").text
    points = browser.execute_script(
        "const root = Bokeh.documents[0].roots().find((r) => r.name === 'run');"
        "const sources = [...root.references()].filter((m) => m.type === 'ColumnDataSource');"
        "return sources.filter((m) => m.data.xs ?? m.data.x).map((m) => (m.data.xs ?? m.data.x).length)"
    )
    assert len(points) == 4
    assert all(n > 1 for n in points)
    labels = browser.execute_script(
        "const root = Bokeh.documents[0].roots().find((r) => r.name === 'run');"
        "return [...root.references()].filter((m) => m.type.endsWith('Axis')).map((m) => m.axis_label)"
    )
    assert "residual over noise floor" in labels
    assert "worst record" in browser.find_element("id", "run-line").text
    assert faults(browser) == []


@pytest.fixture
def endless_search(monkeypatch):
    """Let the search have no end of its own, but ask as a simulation does."""

    def endless(campaign, **options):
        while True:
            check_interruption()
            time.sleep(1e-3)

    monkeypatch.setattr("mechid.web.session.identify", endless)


@pytest.fixture
def short_reload_s(monkeypatch):
    """Let a page count as closed after 3 s, and return this time."""
    monkeypatch.setattr("mechid.web.tab.RELOAD_S", 3.0)
    return 3.0


@pytest.mark.usefixtures("endless_search")
def test_cancel_keeps_what_is_set(browser, address):
    opened(browser, address)
    pressed(browser, "ArrowRight", 3)
    was = told(browser)
    browser.execute_script("document.getElementById('search').click()")
    browser.execute_script("document.getElementById('cancel').click()")
    until(browser, "return mechid.state().run?.state === 'cancelled'")
    for fit in fits_at_work():
        fit.join(SECONDS)
    assert fits_at_work() == []
    now = told(browser)
    assert (now["knobs"], now["verdict"], now["can_undo"]) == (was["knobs"], None, True)
    assert browser.find_element("id", "fit").is_enabled()
    assert "cancelled" in browser.find_element("id", "run-words").text


def fits_at_work():
    return [thread for thread in threading.enumerate() if thread.name == "fit"]


@pytest.mark.usefixtures("endless_search")
def test_closing_the_page_ends_its_fit(browser, address, short_reload_s):
    """Truth: the thread of a fit without an end of its own; a page that is loaded anew comes back sooner."""
    opened(browser, address)
    first = browser.current_window_handle
    browser.switch_to.new_window("tab")
    opened(browser, address)
    browser.find_element("id", "search").click()
    until(browser, "return mechid.state().run?.state === 'running'")
    fits = fits_at_work()
    assert fits
    browser.close()
    browser.switch_to.window(first)
    for fit in fits:
        fit.join(short_reload_s + 5.0)
    assert fits_at_work() == []


@pytest.mark.usefixtures("endless_search")
def test_a_page_loaded_anew_keeps_values_undo_and_the_fit_at_work(browser, address, short_reload_s):
    """Truth: what was set before, and the fit's own thread, which is the same."""
    opened(browser, address)
    asked(browser, do="turn", name=KNOB, value=700.0)
    asked(browser, do="turn", name=KNOB, value=701.0)
    browser.find_element("id", "search").click()
    until(browser, "return mechid.state().run?.state === 'running'")
    fits = fits_at_work()
    browser.refresh()
    idle(browser)
    until(browser, "return mechid.state().run?.state === 'running'")
    assert told(browser)["knobs"][KNOB]["value"] == 701.0
    assert fits_at_work() == fits
    time.sleep(short_reload_s + 1.0)  # the page that was left is not taken for one that closed
    assert fits_at_work() == fits
    asked(browser, do="undo")
    assert told(browser)["knobs"][KNOB]["value"] == 700.0
    asked(browser, do="cancel")
    until(browser, "return mechid.state().run?.state === 'cancelled'")


def test_another_tab_does_not_take_the_session_of_one_that_is_open(browser, address):
    """Truth: a copy of a tab has its token too; the values set in the one that is open stay its own."""
    opened(browser, address)
    first = browser.current_window_handle
    asked(browser, do="turn", name=KNOB, value=702.0)
    token = told(browser)["tab"]
    browser.switch_to.new_window("tab")
    opened(browser, address)
    asked(browser, do="hello", tab=token)
    assert told(browser)["knobs"][KNOB]["value"] != 702.0
    browser.close()
    browser.switch_to.window(first)
    asked(browser, do="settle")
    assert told(browser)["knobs"][KNOB]["value"] == 702.0


def written(browser, value):
    """Write a value into a knob's box, as a hand would."""
    box = "const box = mechid.knobs.get(arguments[0]).querySelector('[type=number]'); box.focus(); box.select();"
    browser.execute_script(box, KNOB)
    browser.execute_cdp_cmd("Input.insertText", {"text": str(value)})
    for kind in ("keyDown", "keyUp"):
        browser.execute_cdp_cmd("Input.dispatchKeyEvent", {"type": kind, "key": "Enter", "code": "Enter", "text": "\r"})
    idle(browser)
    row = "const row = mechid.knobs.get(arguments[0]); return ["
    return browser.execute_script(
        f"{row}row.querySelector('[type=number]').value, row.querySelector('.limit').innerText]", KNOB
    )


@pytest.mark.parametrize(("end", "side"), [("max", "above"), ("min", "below")])
def test_a_value_out_of_bounds_goes_back_to_the_bound_and_is_said(browser, address, source, end, side):
    """Truth: the file's bound, which the model uses."""
    opened(browser, address)
    bound = getattr(source.campaign.mechanism.parameters[KNOB], end)
    asked_for = bound * (10.0 if end == "max" else 0.1)
    for _ in range(2):  # also where the bound is in use already
        shown, said = written(browser, asked_for)
        assert told(browser)["knobs"][KNOB]["value"] == bound
        assert float(shown) == pytest.approx(bound)
        assert said == f"{asked_for:.6g} is {side} the bound of the mechanism file; {bound:.6g} is used"
    shown, said = written(browser, 900.0)
    assert (float(shown), said) == (900.0, "")


def test_the_grade_is_greyed_as_soon_as_a_value_is_not_the_estimates(browser, estimated):
    """Truth: the tone of the verdict as the browser draws it, and the distance in standard errors."""
    address, estimate = estimated
    opened(browser, address)
    colour = "return getComputedStyle(document.getElementById('headline')).color"
    graded, apart = browser.execute_script(colour), browser.find_element("id", "apart")
    assert apart.text == ""
    sigma = estimate.sigmas[KNOB]
    asked(browser, do="turn", name=KNOB, value=estimate.values[KNOB] + 40.0 * sigma)
    assert browser.execute_script(colour) != graded
    assert "1 parameter differs, gear.stiffness by 40 σ" in apart.text
    asked(browser, do="estimate")
    assert (browser.execute_script(colour), apart.text) == (graded, "")


def test_the_picture_is_seen_without_scrolling(browser, estimated):
    """Truth: where the browser draws the torque and its residual on a screen of 1400 x 900."""
    opened(browser, estimated[0])
    top = browser.execute_script("return document.querySelector('.figure.time').getBoundingClientRect().top")
    assert top + TOOLBAR_PX + TORQUE_HEIGHT + RESIDUAL_HEIGHT < 900.0


def test_two_tabs_do_not_disturb_each_other(browser, address):
    opened(browser, address)
    first = browser.current_window_handle
    start = told(browser)["knobs"][KNOB]["value"]
    browser.switch_to.new_window("tab")
    opened(browser, address)
    asked(browser, do="turn", name=KNOB, value=700.0)
    asked(browser, do="free", name=KNOB, **{"is": False})
    browser.close()
    browser.switch_to.window(first)
    asked(browser, do="take", name=KNOB)
    knob = told(browser)["knobs"][KNOB]
    assert (knob["value"], knob["free"]) == (start, True)


@pytest.mark.parametrize("width", [1400, 390])
def test_the_switch_of_an_effect_moves_the_curves_at_once_and_undo_takes_it_back(browser, switched, diagnosed, width):
    """Truth: the simulation with the effect's amplitude at zero."""
    opened(browser, switched, width)
    switch = browser.find_element("css selector", ".effect-named [role=switch]")
    assert switch.is_selected()
    on = browser.execute_script(SOURCE, "time_0")
    browser.execute_script("arguments[0].click()", switch)
    idle(browser)
    off = browser.execute_script(SOURCE, "time_0")
    twin = Session(diagnosed)
    twin.turn(DETENT[0], 0.0)
    picture = twin.pictures()["full_46"]
    kept = np.round(np.array(off["modelled at"]) * synthetic.RATE_HZ).astype(int)
    assert off["modelled"] == picture.modelled[kept].tolist()
    assert off["modelled spectrum"] == picture.modelled_spectrum.tolist()
    assert not switch.is_selected()
    browser.find_element("id", "undo").click()
    idle(browser)
    assert switch.is_selected()
    assert browser.execute_script(SOURCE, "time_0") == on
    said = browser.find_element("css selector", ".effects").text
    assert "Explains 90 % of the misfit" in said
    assert "Tried and not named: 1" in said
    assert browser.execute_script("return document.documentElement.scrollWidth") <= width
    assert faults(browser) == []


@pytest.mark.slow
def test_terms_that_a_fit_elsewhere_added_get_sliders(browser, following, lacking, whole, monkeypatch):
    """Truth: the mechanism that the records are of. The fit's estimate is made up, its journal is a real one."""
    (address, path), (_, estimate) = following, lacking
    monkeypatch.setattr("mechid.web.session.read_estimated", lambda path, campaign: estimate)
    journal = Journal.open(path, {})
    opened(browser, address)
    assert not browser.execute_script("return mechid.knobs.has(arguments[0])", DETENT[0])
    until(browser, "return Boolean(mechid.state().run)")
    path.with_name("estimate.json").write_text("{}")
    journal.note("finished", outcome="converged", message="")
    until(browser, "return mechid.knobs.has(arguments[0])", DETENT[0])
    idle(browser)
    row = browser.find_element("css selector", f'.knob[data-name="{DETENT[0]}"]')
    assert float(row.find_element("css selector", "[type=number]").get_attribute("value")) == whole.value(DETENT[0])
    assert told(browser)["records"][0]["ratio"] == pytest.approx(1.0, abs=0.05)
    asked(browser, do="turn", name=DETENT[0], value=0.0)
    assert told(browser)["records"][0]["ratio"] > 2.0
    browser.execute_script("document.getElementById(arguments[0]).focus()", f"range-{DETENT[0]}")
    idle(browser)
    assert told(browser)["hand"] == DETENT[0]
    browser.refresh()
    until(browser, "return window.mechid && mechid.knobs.has(arguments[0])", DETENT[0])
    assert faults(browser) == []


def test_hostile_titles_columns_and_paths_show_as_text(browser, address, source):
    opened(browser, address)
    folder = source.campaign.path.parent.name
    assert browser.find_element("tag name", "h1").text.split() == folder.split()
    assert browser.title.startswith("<img src=x")
    column = source.campaign.records[0].data.channels[0].column
    assert column in browser.find_element("css selector", ".chip").get_attribute("title")
    assert browser.execute_script("return document.querySelectorAll('img').length") == 0
    asked(browser, do="<script>")
    assert "<script>" in browser.find_element("id", "note").text


def test_the_saved_file_is_the_mechanism_that_is_set(browser, address, tmp_path):
    opened(browser, address)
    asked(browser, do="turn", name=KNOB, value=877.5)
    where = {"behavior": "allow", "downloadPath": str(tmp_path)}
    browser.execute_cdp_cmd("Browser.setDownloadBehavior", where)
    browser.find_element("id", "save").click()
    end = time.monotonic() + SECONDS
    while not (path := tmp_path / "mechanism.toml").exists() and time.monotonic() < end:
        time.sleep(0.05)
    assert load_mechanism(path).value(KNOB) == 877.5
