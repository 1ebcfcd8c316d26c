"""The explorer with an effect that a diagnosis names switched off, as docs/explorer.md shows it.

    python benchmarks/explorer_picture.py FOLDER [PICTURE]

Three records are simulated with a detent of 7.2 deg, which the mechanism file lacks; they are identified and diagnosed
into FOLDER, what is there already is taken up, and the page is photographed in the system's Chromium without a window.
"""

import subprocess
import sys
from pathlib import Path

import numpy as np

import mechid
from mechid.campaign.bench import TRUTH
from mechid.campaign.catalogue_values import CATALOGUE

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from bench_explorer import idle
from browser import chromium

PICTURE = Path(__file__).parents[1] / "docs" / "images" / "explorer_diagnosis.png"
NOISE_NM, RATE_HZ, SECONDS = 0.002, 10_000.0, 1.0
DETENT = {"period_deg": 7.2, "amplitude": 0.003, "phase_deg": 25.0}
COMMANDS = {
    "full_46": mechid.make_command("full", rate=46.0, start_angle_deg=45.0),
    "full_23": mechid.make_command("full", rate=23.0),
    "micro_46": mechid.make_command("micro", microsteps=16, rate=46.0),
}
SCREEN = {"width": 1100, "height": 1000, "deviceScaleFactor": 1, "mobile": False}


def main(folder: Path, picture: Path) -> None:
    """Make what is not there yet, and take the picture."""
    bench, fit, diagnosis = folder / "bench", folder / "fit", folder / "diagnosis"
    if not bench.is_dir():
        write_bench(bench)
    for words in (["identify", bench, "--out", fit], ["diagnose", fit, "--out", diagnosis]):
        if not words[-1].is_dir():
            subprocess.run([sys.executable, "-m", "mechid", *words], check=True)
    asked = [sys.executable, "-m", "mechid", "explore", bench, "--fit", fit, "--diagnosis", diagnosis, "--no-browser"]
    with subprocess.Popen(asked, stdout=subprocess.PIPE, text=True) as explorer:
        try:
            photograph(explorer.stdout.readline().split()[0], picture)
        finally:
            explorer.terminate()


def write_bench(folder: Path) -> None:
    """Write records of a mechanism with one detent more than its file."""
    near = {name: value for name, value in TRUTH.items() if not name.endswith("phase_deg")}
    stepper = {**CATALOGUE["stepper"], "detent": [*CATALOGUE["stepper"]["detent"], DETENT]}
    maker = mechid.make_mechanism({**CATALOGUE, "stepper": stepper}).with_values(TRUTH)
    planned = [mechid.make_record(name, command=command) for name, command in COMMANDS.items()]
    made, rng, records = mechid.make_campaign(maker, planned), np.random.default_rng(5), []
    for name, command in COMMANDS.items():
        run = mechid.simulate(made, name, sample_rate_hz=RATE_HZ, duration_s=SECONDS)
        torque = run.torque + NOISE_NM * rng.standard_normal(run.time.size)
        records.append(mechid.make_record(name, torque, sample_rate_hz=RATE_HZ, command=command))
    mechid.write_campaign(mechid.make_campaign(mechid.catalogue_mechanism().with_values(near), records), folder)


def photograph(address: str, picture: Path) -> None:
    """Switch the first effect off, and photograph the page from its buttons on."""
    with chromium() as browser:
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", SCREEN)
        browser.get(address)
        idle(browser)
        browser.execute_script("mechid.ask({ do: 'look', records: ['full_23'], seconds: 1 })")
        idle(browser)
        browser.execute_script("document.querySelector('.effect-named [role=switch]').click()")
        idle(browser)
        browser.execute_script("document.querySelector('#undo').scrollIntoView(); window.scrollBy(0, -30)")
        idle(browser)
        picture.write_bytes(browser.get_screenshot_as_png())


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]) if len(sys.argv) > 2 else PICTURE)
