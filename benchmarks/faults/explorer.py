"""The explorer's memory while tabs are opened, driven and closed in the system's Chromium."""

import os
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

from faults.reference import Trial

sys.path.insert(0, str(Path(__file__).parents[2] / "tests"))
TABS, WARM, AT_ONCE = 200, 20, 5
MOST_MB = 20.0
FORGOTTEN_S = 40.0
"""Until Bokeh has forgotten a tab that was closed."""


def soak(reference, count):
    """Yield the one trial; `count` is how many tabs."""
    yield Trial(0, f"{count or TABS} tabs opened, driven and closed", partial(_soak, reference, count or TABS))


def _soak(reference, tabs):
    from browser import chromium

    assert reference.fit
    command = [
        sys.executable,
        "-m",
        "mechid",
        "explore",
        str(reference.bench),
        "--fit",
        str(reference.fit),
        "--no-browser",
    ]
    environment = os.environ | {"PYTHONUNBUFFERED": "1"}
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=environment
    ) as server:
        try:
            address = server.stdout.readline().split()[0]
            with chromium() as browser:
                _drive(browser, address, WARM)
                time.sleep(FORGOTTEN_S)
                before = _resident_mb(server.pid)
                _drive(browser, address, tabs)
                time.sleep(FORGOTTEN_S)
                after = _resident_mb(server.pid)
        finally:
            server.terminate()
    grown = after - before
    faults = [f"memory grew by {grown:.1f} MB"] if grown > MOST_MB else []
    return {"faults": faults, "tabs": tabs, "before_mb": before, "after_mb": after}


def _drive(browser, address, tabs):
    """Open tabs by the handful, turn a slider in each, and close them."""
    first = browser.current_window_handle
    for begun in range(0, tabs, AT_ONCE):
        for _ in range(min(AT_ONCE, tabs - begun)):
            browser.switch_to.new_window("tab")
            browser.get(address)
            _idle(browser)
            browser.execute_script(
                "mechid.knobs.get('gear.stiffness').querySelector('[type=range]').focus({ preventScroll: true })"
            )
            for kind in ("keyDown", "keyUp"):
                browser.execute_cdp_cmd(
                    "Input.dispatchKeyEvent", {"type": kind, "key": "ArrowRight", "code": "ArrowRight"}
                )
            _idle(browser)
        for handle in browser.window_handles:
            if handle != first:
                browser.switch_to.window(handle)
                browser.close()
        browser.switch_to.window(first)


def _idle(browser):
    until = time.monotonic() + 60.0
    while not browser.execute_script("return Boolean(window.mechid) && mechid.idle()"):
        assert time.monotonic() < until, "the page did not answer"
        time.sleep(0.05)


def _resident_mb(pid):
    pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6
