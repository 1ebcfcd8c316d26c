"""`mechid check`; truth: what the test wrote into the files."""

import hashlib
import json
import re
import subprocess
import sys

import pytest

LOADED = """
import sys
from mechid.cli import main
try:
    main()
finally:
    print(*sys.modules, sep="\\n")
"""


def warnings(result):
    return [line for line in result.stdout.splitlines() if line.startswith("warning: ")]


def test_a_good_campaign_is_told_without_a_warning(run, folder):
    result = run("check", folder)
    assert result.exit_code == 0
    assert warnings(result) == []
    assert "full stepping at 46 full steps/s, from 45 deg: 46 step edges" in result.stdout
    assert "10001 samples at 10000 Hz, 0 s to 1 s" in result.stdout
    assert "15 parameters to be estimated" in result.stdout
    assert "stepper.back_emf_constant follows stepper.torque_constant" in result.stdout


def test_a_check_loads_nothing_that_it_has_no_use_for(folder):
    """What is named takes nearly a second to load together; `scipy.stats` has the points of the searches."""
    result = subprocess.run([sys.executable, "-c", LOADED, "check", folder], capture_output=True, text=True, check=True)
    loaded = set(result.stdout.splitlines())
    assert "mechid.kernel.compiled" in loaded
    assert not {"bokeh", "jinja2", "matplotlib", "pint", "scipy.signal"} & loaded


def test_the_kernel_is_told_on_stderr_as_what_it_was(run, folder):
    result = run("check", folder)
    assert "kernel loaded from the cache in" in result.stderr
    assert "cache" not in result.stdout


def test_a_record_shorter_than_its_command_is_warned(run, changed):
    folder = changed("campaign.toml", "[[0.0, 0.0], [1.0, 2.0]]", "[[0.0, 0.0], [4.0, 8.0]]")
    result = run("check", folder)
    assert result.exit_code == 0
    assert len(warnings(result)) == 1
    assert 'record "sweep"' in warnings(result)[0]
    assert "4 s" in warnings(result)[0]


@pytest.mark.slow
def test_more_than_one_edge_a_sample_is_warned(run, changed):
    result = run("check", changed("campaign.toml", "microsteps = 16, rate = 92.0", "microsteps = 256, rate = 92.0"))
    assert result.exit_code == 0
    assert any("micro_92" in line and "between two samples" in line for line in warnings(result))


@pytest.mark.slow
def test_a_parameter_that_no_record_sees_is_warned_with_its_remedy(run, changed):
    """A detent known to be zero has a phase that changes nothing."""
    folder = changed("mechanism.toml", "amplitude = { value = 0.0, min = 0.0, max = 0.1 }", "amplitude = 0.0  ")
    result = run("check", folder)
    assert result.exit_code == 0
    assert warnings(result) == [
        "warning: stepper.detent.1.phase_deg: no record sees it; add a record that does, or give it as a known number"
    ]


def test_a_mechanism_that_diverges_is_warned(run, changed):
    result = run("check", changed("mechanism.toml", "inertia = 0.010534", "inertia = 1e-9"))
    assert result.exit_code == 0
    assert any('record "full_23" at' in line for line in warnings(result))


def test_stages_are_told(run, staged):
    result = run("check", staged)
    assert "stage 1: gear.stiffness, gear.damping; full_46, 0 s to 0.05 s" in result.stdout


@pytest.mark.slow
def test_a_picture_of_each_record_has_its_channels_and_its_command(run, folder, tmp_path):
    """Truth: the labels that must stand in it; the SVG keeps text as text. The spectrum has the command's orders."""
    result = run("check", folder, "--out", tmp_path / "pictures")
    assert result.exit_code == 0
    for name in ("full_46", "sweep"):
        path = tmp_path / "pictures" / f"{name}.svg"
        assert f"written: {path}" in result.stdout
        text = path.read_text()
        assert all(label in text for label in (name, "torque,", "N m", "time, s", "rate,", "full steps/s"))
        assert path.with_suffix(".png").stat().st_size > 5000
    spectrum = (tmp_path / "pictures" / "full_46_spectrum.svg").read_text()
    assert all(label in spectrum for label in ("frequency, Hz", "amplitude, N m", "level around", ">1<", ">2<"))
    assert "step rate, full steps/s" in (tmp_path / "pictures" / "sweep_waterfall.svg").read_text()
    assert not (tmp_path / "pictures" / "full_46_waterfall.svg").exists()


def test_its_page_its_markdown_and_its_numbers_lie_beside_the_pictures(run, folder, tmp_path):
    """Truth: the names of the bench's records and parameters."""
    assert run("check", folder, "--out", tmp_path).exit_code == 0
    page, text = ((tmp_path / f"check.{suffix}").read_text(encoding="utf-8") for suffix in ("html", "md"))
    for name in ("full_46", "sweep"):
        assert f'<h2 id="record-{name}">' in page
        assert f'id="figure-{name}_spectrum"' in page
        assert f"(<{name}.svg>)" in text.replace("\\", "")
        assert (tmp_path / f"{name}.svg").is_file()
    linked = set(re.findall(r"\(<(.*?)>\)", text))
    assert linked == {path.name for path in tmp_path.glob("*.svg")}
    data = json.loads((tmp_path / "check.json").read_text(encoding="utf-8"))
    assert data["format"] == "mechid-check/1"
    assert (
        data["provenance"]["inputs_sha256"]["sweep.csv"]
        == hashlib.sha256((folder / "sweep.csv").read_bytes()).hexdigest()
    )


def test_a_picture_of_a_bare_file_is_refused(run, folder, tmp_path):
    result = run("check", folder / "full_46.csv", "--out", tmp_path)
    assert result.exit_code == 2
    assert "--out" in result.stderr
