"""Every command on a fit that added a harmonic of the torque constant, which its mechanism file lacks.

Truth: the mechanism that made the records, by a simulator of their own (`benchmarks/incomplete`), and the same records
identified with the harmonic in the file.
"""

import json
import re
import shutil
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

from incomplete.benches import make_bench
from mechid.budgets.example import BUDGET, write_example
from mechid.campaign import load_campaign
from mechid.cli.app import app
from mechid.web import read_estimated
from mechid.web.run import load_source
from mechid.web.session import Session

pytestmark = pytest.mark.slow

TERM, WORDS = "stepper.torque_harmonic:3", "3rd harmonic of the torque constant"
HELD_OUT = ('name = "half_res"\n', 'name = "half_res"\nuse = "validate"\n')
AMPLITUDE = "stepper.torque_harmonic.0.amplitude"
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
    assert f"found, not declared: {TERM}: {WORDS} (below)" in walked.said
    assert [one["name"] for one in estimate["missing"]] == [TERM], "no other term is needed"
    assert "beside" not in estimate
    found = estimate["parameters"][AMPLITUDE]
    assert found["added"]
    assert abs(found["value"] - walked.size["harmonic"]) < 4.0 * found["std_error"]
    free = {n: p for n, p in estimate["parameters"].items() if p["std_error"] and not p["added"]}
    assert len(free) == len(walked.truth) == 15
    off = [
        ((p["value"] - walked.truth[n] + 180.0) % 360.0 - 180.0) / p["std_error"]
        if p["unit"] == "deg"
        else (p["value"] - walked.truth[n]) / p["std_error"]
        for n, p in free.items()
    ]
    assert max(map(abs, off)) < 4.0
    assert f"# added by mechid: {WORDS}; the records need it" in (walked.fit / "mechanism.toml").read_text()


def test_report_makes_the_same_anew(walked):
    before = (walked.fit / "report.md").read_text(encoding="utf-8")
    (walked.fit / "report.html").unlink()
    done("report", walked.fit)
    text, page = ((walked.fit / f"report.{suffix}").read_text(encoding="utf-8") for suffix in ("md", "html"))
    assert text == before
    assert all(f"Not declared: {WORDS}" in shown for shown in (text, page))


def test_every_figure_is_of_the_mechanism_that_was_left(walked, estimate, tmp_path):
    """Truth: `mechid simulate` of the mechanism file in the result folder, offset and drift fitted; all records.

    The record held out among them: with the harmonic in the file it is predicted to the noise too.
    """
    folder = shutil.copytree(walked.folder / "bench", tmp_path / "left")
    shutil.copy(walked.fit / "mechanism.toml", folder / "mechanism.toml")
    done("simulate", folder, "--out", tmp_path / "runs")
    shown = {row["name"]: row["residual_rms"] for row in read(walked.fit / "report.json")["records"]}
    for name, own in estimate["records"].items():
        measured, simulated = (
            np.loadtxt(f, delimiter=",", skiprows=1)[:, 1]
            for f in (folder / f"{name}.csv", tmp_path / f"runs/{name}.csv")
        )
        rest = measured - simulated
        line = np.stack([np.ones(rest.size), np.linspace(-1.0, 1.0, rest.size)], axis=1)
        rest = rest - line @ np.linalg.lstsq(line, rest, rcond=None)[0]
        rms = np.sqrt(np.mean(rest**2))
        assert own["residual_rms"] == pytest.approx(rms, rel=1e-6), name
        assert shown[name] == own["residual_rms"]
        assert own["validation"]["channels"]["torque"]["residual_rms"] == pytest.approx(rms, rel=1e-6), name
    held_out = estimate["records"]["half_res"]
    assert held_out["use"] == "validate"
    assert held_out["residual_rms"] < 1.1 * held_out["noise_sigma"]
    assert estimate["as_written"]["residual_over_noise"]["half_res"] > 1.3
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


def test_a_term_has_a_profile_too(walked, estimate, tmp_path):
    done("profile", walked.fit, "--parameter", AMPLITUDE, "--out", tmp_path, "--workers", 1)
    content, own = read(tmp_path / "profile.json")["profiles"][AMPLITUDE], estimate["parameters"][AMPLITUDE]
    assert content["value"] == pytest.approx(own["value"], abs=0.05 * own["std_error"])


def test_compare_finds_the_fit_and_that_of_the_file_with_the_harmonic_alike(walked, tmp_path):
    """They are of the same model, which one file declares and the other fit added."""
    done("compare", walked.fit, walked.whole, "--out", tmp_path)
    scores = read(tmp_path / "comparison.json")["scores"]
    assert [row["grade"] for row in scores] == ["B", "A"]


def test_the_explorer_takes_up_values_and_verdict(walked, estimate):
    source = load_source(walked.campaign, fit=walked.fit)
    shown = source.estimate
    session = Session(source)
    assert session.estimate is shown
    assert AMPLITUDE in session.state.knobs
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


def test_a_budget_flies_the_term(walked, tmp_path):
    """Truth: the same budget of the fit with the harmonic in its file."""
    scan = BUDGET[: BUDGET.index('[[mode]]\nname = "slew"')] + BUDGET[BUDGET.index("[[requirement]]") :]
    scan = re.sub(r"rate_range = .*|duty = .*", "", scan).replace("[[mode]]\n", "[[mode]]\nrates = [47.5]\n")
    lacking = {}
    for name, fit in (("bench", walked.fit), ("whole", walked.whole)):
        folder = shutil.copytree(fit, tmp_path / name)
        write_example(folder)
        (folder / "budget.toml").write_text(scan, encoding="utf-8")
        assert "lacks terms" not in done("budget", folder / "budget.toml", "--out", tmp_path / f"{name}_budget")
        (mode,) = read(tmp_path / f"{name}_budget" / "budget.json")["modes"]
        lacking[name] = mode["line_of_sight_rms_lacking_rad"][0]
    assert lacking["bench"] == pytest.approx(lacking["whole"], rel=0.1)


def test_an_export_has_the_term(walked, tmp_path):
    """Truth: the kernel of the mechanism that was left, against which the export is checked."""
    done("export", walked.fit, "--to", "c", "--out", tmp_path)
    made = read(tmp_path / "mechid_export.json")
    assert made["checked"]["rms_error"] < 1e-9
    assert "torque_harmonic" in (tmp_path / "mechanism.h").read_text() + (tmp_path / "mechanism.c").read_text()


def test_diagnose_names_the_harmonic(walked, tmp_path):
    printed = done("diagnose", walked.fit, "--out", tmp_path / "diagnosis", "--workers", 1)
    assert TERM in printed
    content = read(tmp_path / "diagnosis" / "diagnose.json")
    (one,) = content["missing"]
    assert (one["name"], one["words"]) == (TERM, WORDS)
    amplitude = one["parameters"][AMPLITUDE]
    assert abs(amplitude["value"] - walked.size["harmonic"]) < 4.0 * amplitude["std_error"]


def test_a_mechanism_completes_itself_and_every_command_goes_on_with_it(walked, tmp_path):
    """The completed fit is that of the file in which the harmonic was written by hand."""
    folder = tmp_path / "completed"
    done("identify", walked.folder / "bench", "--out", folder, "--workers", 1, "--complete")
    found, by_hand = read(folder / "estimate.json"), read(walked.whole / "estimate.json")
    assert found["grade"] == "A"
    added, removed = ([step[key] for step in found["completed"] if step[key]] for key in ("added", "removed"))
    assert set(added) - set(removed) == {TERM}
    assert found["as_written"] is None
    assert not any(p["added"] for p in found["parameters"].values())
    for name, p in by_hand["parameters"].items():
        if p["std_error"] and p["unit"] != "deg":
            assert abs(found["parameters"][name]["value"] - p["value"]) < p["std_error"], name
    done("report", folder)
    done("profile", folder, "--parameter", "gear.stiffness", "--out", tmp_path / "profile", "--workers", 1)
    assert "nothing is left to explain" in done("diagnose", folder, "--out", tmp_path / "again").lower()
    campaign = load_campaign(walked.campaign, mechanism_file=folder / "mechanism_completed.toml")
    assert read_estimated(folder / "estimate.json", campaign).values[AMPLITUDE] > 0.0
