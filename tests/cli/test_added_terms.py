"""Every command on a fit whose mechanism file lacks a harmonic of the torque constant, so that terms stand beside it.

Truth: the mechanism that made the records, by a simulator of their own (`benchmarks/incomplete`), and the same records
identified with the harmonic in the file.
"""

import json
import re
import shutil
from types import SimpleNamespace

import pytest
from typer.testing import CliRunner

from incomplete.benches import make_bench
from mechid.budgets.example import BUDGET, write_example
from mechid.campaign import load_campaign
from mechid.cli.app import app
from mechid.web import Source, read_estimated
from mechid.web.session import Session

pytestmark = pytest.mark.slow

TERM, WORDS = "stepper.torque_harmonic:3", "3rd harmonic of the torque constant"
HELD_OUT = ('name = "half_res"\n', 'name = "half_res"\nuse = "validate"\n')
HARMONIC = """
[[stepper.torque_harmonic]]
order = 3
amplitude = { value = 0.005, min = 0.0, max = 0.1 }
phase_deg = { value = -130.0 }
"""
DESIGN = """
[recording]
noise_Nm = 0.002
[candidates]
steppings = ["full"]
rates = [23.0, 46.0]
start_angles_deg = [45.0]
sweeps_s = []
[limits]
between_s = 1.0
total_s = 6.0
[prior]
mechanisms = 2
"""


def done(*arguments):
    """Run mechid, which has to end well, and return what it printed."""
    result = CliRunner().invoke(app, [str(argument) for argument in arguments], prog_name="mechid")
    assert result.exit_code == 0, result.stderr
    return result.stdout


def read(path):
    return json.loads(path.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def walked(tmp_path_factory):
    """Return a bench with a record held out, and its fit as it is and with the harmonic in the mechanism file."""
    folder = tmp_path_factory.mktemp("walk")
    bench = make_bench("torque_harmonic", 0, folder / "bench")
    campaign = folder / "bench" / "campaign.toml"
    text = campaign.read_text()
    assert HELD_OUT[0] in text
    campaign.write_text(text.replace(*HELD_OUT))
    whole = shutil.copytree(folder / "bench", folder / "whole")
    with (whole / "mechanism.toml").open("a") as file:
        file.write(HARMONIC)
    said = {
        name: done("identify", folder / name, "--out", folder / f"{name}_fit", "--workers", 1)
        for name in ("bench", "whole")
    }
    return SimpleNamespace(
        folder=folder,
        campaign=campaign,
        fit=folder / "bench_fit",
        whole=folder / "whole_fit",
        said=said["bench"],
        truth=bench.truth,
        size=bench.size,
    )


@pytest.fixture
def estimate(walked):
    return read(walked.fit / "estimate.json")


def test_identify_shows_the_term_and_finds_the_truth(walked, estimate):
    assert estimate["grade"] == "B"
    assert [reason["cause"] for reason in estimate["grade_reasons"]] == ["incomplete"]
    assert "Terms beside the mechanism file" in walked.said.splitlines()
    assert f"{WORDS} ({TERM})" in walked.said
    found = estimate["beside"]["parameters"]["stepper.torque_harmonic.0.amplitude"]
    assert abs(found["value"] - walked.size["harmonic"]) < 4.0 * found["std_error"]
    free = {n: p for n, p in estimate["parameters"].items() if p["std_error"]}
    assert len(free) == len(walked.truth) == 15
    off = [
        ((p["value"] - walked.truth[n] + 180.0) % 360.0 - 180.0) / p["std_error"]
        if p["unit"] == "deg"
        else (p["value"] - walked.truth[n]) / p["std_error"]
        for n, p in free.items()
    ]
    assert max(map(abs, off)) < 4.0
    assert "INCOMPLETE" in (walked.fit / "mechanism.toml").read_text()


def test_report_makes_the_same_anew(walked):
    before = (walked.fit / "report.md").read_text(encoding="utf-8")
    (walked.fit / "report.html").unlink()
    done("report", walked.fit)
    text, page = ((walked.fit / f"report.{suffix}").read_text(encoding="utf-8") for suffix in ("md", "html"))
    assert text == before
    assert all("Terms beside the mechanism file" in shown and WORDS in shown for shown in (text, page))


def test_the_record_held_out_is_predicted_by_the_mechanism_as_written(walked, estimate):
    """Truth: with the harmonic in the file it is predicted to the noise."""
    own, whole = (e["records"]["half_res"] for e in (estimate, read(walked.whole / "estimate.json")))
    assert whole["residual_rms"] < 1.1 * whole["noise_sigma"]
    assert own["use"] == "validate"
    assert own["residual_rms"] > 1.3 * own["noise_sigma"]
    assert own["validation"]["channels"]["torque"]["residual_rms"] == pytest.approx(own["residual_rms"], rel=1e-3)
    assert "Prediction of the records held out" in walked.said


def test_a_profile_is_of_the_fit_with_its_terms(walked, estimate, tmp_path):
    """Truth: the interval by the standard error, to which a profile comes where the fit is nearly linear.

    Without the terms the residual would be several times the noise, and the profile's optimum elsewhere.
    """
    done("profile", walked.fit, "--parameter", "gear.stiffness", "--out", tmp_path, "--workers", 1)
    content = read(tmp_path / "profile.json")["profiles"]["gear.stiffness"]
    error = estimate["parameters"]["gear.stiffness"]["std_error"]
    assert content["value"] == pytest.approx(estimate["parameters"]["gear.stiffness"]["value"], abs=0.05 * error)
    width, local = (high - low for low, high in (content["ci95"], content["ci95_local"]))
    assert 0.5 < width / local < 2.0


def test_a_profile_of_a_term_is_refused(walked, refused, tmp_path):
    line = refused(2, "profile", walked.fit, "--parameter", "stepper.torque_harmonic.0.amplitude", "--out", tmp_path)
    assert "is not in the fit" in line


def test_compare_prefers_the_file_with_the_harmonic(walked, tmp_path):
    said = done("compare", walked.fit, walked.whole, "--out", tmp_path)
    assert said.splitlines()[0].endswith("Preferred: whole_fit.")
    assert [row["grade"] for row in read(tmp_path / "comparison.json")["scores"]] == ["B", "A"]


def test_the_explorer_takes_up_values_and_verdict(walked, estimate):
    campaign = load_campaign(walked.campaign)
    shown = read_estimated(walked.fit / "estimate.json", campaign)
    session = Session(Source(campaign, estimate=shown))
    assert session.estimate is shown
    assert set(shown.values) == set(estimate["parameters"])
    assert shown.values["gear.stiffness"] == estimate["parameters"]["gear.stiffness"]["value"]
    answers = [line for question in shown.summary["questions"] for line in question["answers"]]
    assert estimate["grade_reasons"][0]["text"] in answers


def test_design_begins_with_what_the_fit_knows(walked, estimate, tmp_path):
    (tmp_path / "design.toml").write_text(DESIGN, encoding="utf-8")
    asked, out = tmp_path / "design.toml", tmp_path / "out"
    done("design", walked.campaign, "--design", asked, "--fit", walked.fit, "--out", out, "--workers", 1)
    made = read(out / "design.json")
    assert made["after_fit"]
    known = {p["name"]: p for p in made["parameters"]}
    assert {n for n, p in estimate["parameters"].items() if p["std_error"]} <= known.keys()
    assert known["gear.stiffness"]["chosen"] < known["gear.stiffness"]["planned"]


def test_a_budget_flies_the_mechanism_as_written_and_counts_what_it_lacks(walked, tmp_path):
    """Truth: the same budget of the fit with the harmonic in its file, which lacks less."""
    scan = BUDGET[: BUDGET.index('[[mode]]\nname = "slew"')] + BUDGET[BUDGET.index("[[requirement]]") :]
    scan = re.sub(r"rate_range = .*|duty = .*", "", scan).replace("[[mode]]\n", "[[mode]]\nrates = [47.5]\n")
    lacking = {}
    for name, fit in (("bench", walked.fit), ("whole", walked.whole)):
        folder = shutil.copytree(fit, tmp_path / name)
        write_example(folder)
        (folder / "budget.toml").write_text(scan, encoding="utf-8")
        said = done("budget", folder / "budget.toml", "--out", tmp_path / f"{name}_budget")
        assert (f"what flies lacks terms that the records ask for ({WORDS})" in said) is (name == "bench")
        (mode,) = read(tmp_path / f"{name}_budget" / "budget.json")["modes"]
        lacking[name] = mode["line_of_sight_rms_lacking_rad"][0]
    assert lacking["bench"] > 1.5 * lacking["whole"]


def test_diagnose_names_the_harmonic(walked, tmp_path):
    printed = done("diagnose", walked.fit, "--out", tmp_path / "diagnosis", "--workers", 1)
    assert TERM in printed
    content = read(tmp_path / "diagnosis" / "diagnose.json")
    (one,) = content["missing"]
    assert (one["name"], one["words"]) == (TERM, WORDS)
    amplitude = one["parameters"]["stepper.torque_harmonic.0.amplitude"]
    assert abs(amplitude["value"] - walked.size["harmonic"]) < 4.0 * amplitude["std_error"]


def test_a_mechanism_completes_itself_and_every_command_goes_on_with_it(walked, tmp_path):
    """The completed fit is that of the file in which the harmonic was written by hand."""
    folder = tmp_path / "completed"
    done("identify", walked.folder / "bench", "--out", folder, "--workers", 1, "--complete")
    found, by_hand = read(folder / "estimate.json"), read(walked.whole / "estimate.json")
    assert found["grade"] == "A"
    added, removed = ([step[key] for step in found["completed"] if step[key]] for key in ("added", "removed"))
    assert set(added) - set(removed) == {TERM}
    assert found["beside"] is None
    for name, p in by_hand["parameters"].items():
        if p["std_error"] and p["unit"] != "deg":
            assert abs(found["parameters"][name]["value"] - p["value"]) < p["std_error"], name
    done("report", folder)
    done("profile", folder, "--parameter", "gear.stiffness", "--out", tmp_path / "profile", "--workers", 1)
    assert "nothing is left to explain" in done("diagnose", folder, "--out", tmp_path / "again").lower()
    campaign = load_campaign(walked.campaign, mechanism_file=folder / "mechanism_completed.toml")
    assert read_estimated(folder / "estimate.json", campaign).values["stepper.torque_harmonic.0.amplitude"] > 0.0
