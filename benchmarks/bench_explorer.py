"""From the turn of a slider to its curves on the screen, in the system's Chromium without a window.

    python benchmarks/bench_explorer.py ADDRESS

ADDRESS is what ``mechid explore mechid-demo --no-browser`` prints. Each turn is a press of an arrow key; its time ends
with the frame in which torque, residual and spectrum are drawn, as the page itself takes it.
"""

import statistics
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from browser import chromium

TURNS, PAUSE_S = 40, 0.15
CASES = {"one record of 1 s": ["full_46"], "two side by side": ["full_46", "micro_46"]}


def main(address: str) -> None:
    """Print the quartiles of each case."""
    with chromium() as browser:
        screen = {"width": 1400, "height": 1000, "deviceScaleFactor": 1, "mobile": False}
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
        browser.get(address)
        for words, records in CASES.items():
            taken = measured(browser, records)
            first, middle, third = statistics.quantiles(taken, n=4)
            print(f"{words}: {len(taken)} turns, median {middle:.0f} ms, quartiles {first:.0f} and {third:.0f} ms")


def measured(browser, records):
    """Return the time of each turn, ms."""
    idle(browser)
    browser.execute_script("mechid.ask({ do: 'look', records: arguments[0], seconds: 1 })", records)
    idle(browser)
    time.sleep(1.0)
    browser.execute_script(
        "window.scrollTo(0, document.querySelector('.panel').offsetTop); mechid.latencies.length = 0;"
        "mechid.knobs.get('gear.stiffness').querySelector('[type=range]').focus({ preventScroll: true })"
    )
    for turn in range(TURNS):
        key = "ArrowRight" if turn < TURNS // 2 else "ArrowLeft"
        for kind in ("keyDown", "keyUp"):
            browser.execute_cdp_cmd("Input.dispatchKeyEvent", {"type": kind, "key": key, "code": key})
        time.sleep(PAUSE_S)
    idle(browser)
    return browser.execute_script("return mechid.latencies")


def idle(browser):
    """Wait until the page has had its answers."""
    while not browser.execute_script("return Boolean(window.mechid) && mechid.idle()"):
        time.sleep(0.05)


if __name__ == "__main__":
    main(sys.argv[1])
