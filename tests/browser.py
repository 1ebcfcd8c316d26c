"""The system's Chromium, driven without a window, for the tests of pages."""

import base64
import json
import os
import shutil
from contextlib import contextmanager

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome")
OPTIONS = ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu", "--hide-scrollbars")
REQUIRED = "MECHID_NEEDS_BROWSER"
SECONDS = 60


@contextmanager
def chromium():
    """Yield a driver of the system's browser; without one the test is skipped, or fails where one is required."""
    program, driver = next(filter(None, map(shutil.which, NAMES)), None), shutil.which("chromedriver")
    if not (program and driver):
        assert os.environ.get(REQUIRED) != "1", f"{REQUIRED} is 1, and there is no chromium with chromedriver"
        pytest.skip("no browser: install chromium and chromium-driver (Debian), or chromium and chromedriver")
    webdriver = pytest.importorskip("selenium.webdriver", reason="no Selenium: install mechid[dev]")
    options = webdriver.ChromeOptions()
    options.binary_location = program
    for option in OPTIONS:
        options.add_argument(option)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    browser = webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))
    browser.set_script_timeout(SECONDS)
    try:
        yield browser
    finally:
        browser.quit()


def shown(browser, path, width, *, dark=False):
    """Open a file at a width in CSS pixels, as a phone below 500, and draw all of its figures."""
    scheme = [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]
    screen = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 500}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": scheme})
    browser.get_log("browser"), browser.get_log("performance")
    browser.get(path.as_uri())
    waited(browser, "for (const f of document.querySelectorAll('.figure[data-kind]')) await mechid.draw(f);")


def waited(browser, script):
    """Run the body of an async function to its end and return what it returns; an error of it fails the test."""
    wrapped = f"const done = arguments[0]; (async () => {{ {script} }})().then(done, (e) => done('failed: ' + e.stack))"
    result = browser.execute_async_script(wrapped)
    assert not str(result).startswith("failed: "), result
    return result


def requests(browser):
    """Return the addresses asked for since the page was opened, those within the page left out."""
    messages = [json.loads(entry["message"])["message"] for entry in browser.get_log("performance")]
    sent = [m["params"]["request"]["url"] for m in messages if m["method"] == "Network.requestWillBeSent"]
    return [url for url in sent if not url.startswith(("data:", "blob:"))]


def faults(browser):
    """Return what the console holds above a remark."""
    return [e["message"] for e in browser.get_log("browser") if e["level"] in ("SEVERE", "WARNING")]


def printed_to_pdf(browser):
    """Return the page as a PDF, bytes."""
    answer = browser.execute_cdp_cmd("Page.printToPDF", {"preferCSSPageSize": True, "printBackground": True})
    return base64.b64decode(answer["data"])
