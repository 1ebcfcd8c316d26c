"""`mechid fleet`. Truth: benches of known mechanisms, and what is promised of files, exit codes, resumption."""

import csv
import json
import shutil
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context

import pytest

import mechid
from estimates import free
from mechid.campaign.bench import write_bench
from mechid.cli.identification import INTERRUPTED
from mechid.fleets import unit_run
from mechid.identification import run as identification
from mechid.identification.result.grade import FitOutcome
from synthetic_fleet import drawn, write_fit, write_fleet_file


@pytest.fixture
def units(staged, tmp_path):
    """Return the folders of two campaigns of one short record, with a short stage."""
    content = (staged / "campaign.toml").read_text(encoding="utf-8")
    (head, *records), stage = content.partition("[[stage]]")[0].split("[[record]]"), content.partition("[[stage]]")[2]
    kept = next(record for record in records if "full_46" in record)
    (staged / "campaign.toml").write_text(f"{head}[[record]]{kept}[[stage]]{stage}", encoding="utf-8")
    out = [shutil.copytree(staged, tmp_path / name) for name in ("FM1", "FM2")]
    other = write_bench(tmp_path / "other", 4, sweep_s=1.0).parent
    shutil.copy(other / "full_46.csv", out[1])
    return out


def estimate(folder, unit):
    return json.loads((folder / "units" / unit / "estimate.json").read_text(encoding="utf-8"))


def hows(folder):
    content = json.loads((folder / "fleet.json").read_text(encoding="utf-8"))
    return {c["label"]: (c["how"], c["said"]) for c in content["campaigns"]}


@pytest.mark.usefixtures("without_reports")
def test_campaigns_are_identified_taken_up_and_done_anew_where_they_have_changed(run, units, tmp_path):
    """Two benches of one mechanism, with other noise; stiffness 913.47 N m/rad in both."""
    out = tmp_path / "fleet"
    arguments = ("fleet", *units, "--out", out, "--workers", 1)
    result = run(*arguments)
    assert result.exit_code == 0, result.stderr
    files = ["fleet.csv", "fleet.html", "fleet.json", "fleet.md"]
    assert sorted(p.name for p in out.iterdir()) == ["figures", *files, "units"]
    assert set(hows(out).values()) == {("identified", "")}
    stiffness = next(
        p for p in json.loads((out / "fleet.json").read_text())["parameters"] if p["name"] == "gear.stiffness"
    )
    assert abs(stiffness["mean"] - 913.47) < 5.0 * stiffness["std_error"]

    path = units[1] / "full_46.csv"  # nothing changed in FM1, a sample in FM2
    lines = path.read_text(encoding="utf-8").splitlines()
    path.write_text("\n".join([*lines[:-1], lines[-1].split(",")[0] + ",0.0"]) + "\n", encoding="utf-8")
    before = estimate(out, "FM1")
    result = run(*arguments)
    assert result.exit_code == 0, result.stderr
    assert hows(out)["FM1"] == ("taken_up", "")
    how, said = hows(out)["FM2"]
    assert how == "changed"
    assert said.startswith("changed: full_46.csv, record full_46")
    assert "FM2: identified anew (changed: full_46.csv, record full_46)" in result.stderr
    assert estimate(out, "FM1") == before

    (units[0] / "full_46.csv").unlink()  # a failed one does not stop the others, and has no estimate of before
    result = run(*arguments)
    assert result.exit_code == 5
    assert hows(out)["FM2"] == ("taken_up", "")
    assert hows(out)["FM1"][0] == "none"
    assert "full_46.csv" in hows(out)["FM1"][1]
    assert "1 of 2 campaigns have no estimate to use: FM1" in result.stderr


@pytest.mark.slow
@pytest.mark.usefixtures("without_reports")
def test_another_seed_is_another_identification_and_a_fit_beside_its_campaign_is_taken_up(run, units, tmp_path):
    out, unit = tmp_path / "fleet", units[0]
    assert run("identify", unit, "--out", unit, "--workers", 1).exit_code == 0
    assert run("fleet", unit, "--out", out, "--workers", 1).exit_code == 0
    assert hows(out)["FM1"] == ("given", "")
    assert not (out / "units").exists()
    assert run("fleet", unit, "--out", out, "--workers", 1, "--seed", 3).exit_code == 0
    assert hows(out)["FM1"] == ("identified", "")


@pytest.mark.usefixtures("without_reports")
def test_an_interrupted_fleet_goes_on_from_its_journals(run, units, tmp_path, monkeypatch):
    out, real = tmp_path / "fleet", identification.search

    def interrupted_at_the_second(campaign, **options):
        fit = real(campaign, **options)
        if campaign.path.parent.name != "FM2":
            return fit
        return replace(fit, outcome=FitOutcome.INTERRUPTED)

    monkeypatch.setattr(identification, "search", interrupted_at_the_second)
    result = run("fleet", *units, "--out", out, "--workers", 1)
    assert result.exit_code == INTERRUPTED
    assert not (out / "fleet.json").exists()
    monkeypatch.setattr(identification, "search", real)
    result = run("fleet", *units, "--out", out, "--workers", 1)
    assert result.exit_code == 0, result.stderr
    assert {label: how for label, (how, _) in hows(out).items()} == {"FM1": "taken_up", "FM2": "resumed"}


@pytest.mark.usefixtures("without_reports")
def test_a_fault_in_one_campaign_is_said_and_the_others_go_on(run, units, tmp_path, monkeypatch):
    real = unit_run.identify_into_folder

    def broken(campaign, *rest, **options):
        if campaign.path.parent.name == "FM1":
            raise ZeroDivisionError("a fault")
        return real(campaign, *rest, **options)

    monkeypatch.setattr(unit_run, "identify_into_folder", broken)
    result = run("fleet", *units, "--out", tmp_path / "fleet", "--workers", 1)
    assert result.exit_code == 5
    assert hows(tmp_path / "fleet")["FM1"] == ("none", "unexpected error, ZeroDivisionError: a fault")
    assert hows(tmp_path / "fleet")["FM2"][0] == "identified"


def test_the_table_has_a_row_for_each_parameter_of_each_campaign(run, tmp_path):
    drawn(tmp_path, 6, seed=5)
    entries = [{"folder": f'"FM{k:02d}"', "group": '"lot, 1"', "covariates": f"{{ T = {k}.5 }}"} for k in range(6)]
    out = tmp_path / "fleet"
    result = run("fleet", write_fleet_file(tmp_path, entries), "--out", out)
    assert result.exit_code == 0, result.stderr
    with (out / "fleet.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    data = json.loads((out / "fleet.json").read_text(encoding="utf-8"))
    assert len(rows) == 6 * 5
    first, p = rows[0], data["parameters"][0]
    assert (first["campaign"], first["group"], first["T"], first["parameter"]) == ("FM00", "lot, 1", "0.5", p["name"])
    assert float(first["value"]) == pytest.approx(p["values"][0]["value"], rel=1e-9)
    assert float(first["std_error"]) == pytest.approx(p["values"][0]["std_error"], rel=1e-9)
    assert float(first["fleet_spread"]) == pytest.approx(p["spread"], rel=1e-9)


def test_exit_codes(run, refused, tmp_path):
    good = write_fit(tmp_path / "good", {"gear.stiffness": free(900.0, 1.0)})
    bad = write_fit(tmp_path / "bad", {"gear.stiffness": free(900.0, 1.0)}, grade="C")
    assert run("fleet", good, "--out", tmp_path / "out").exit_code == 0
    assert "have no estimate to use: bad;" in refused(5, "fleet", good, bad, "--out", tmp_path / "out")
    (tmp_path / "fleet.toml").write_text("[[campaign]]\nfolder = 3\n", encoding="utf-8")
    assert "campaign[0].folder: found 3" in refused(3, "fleet", tmp_path / "fleet.toml", "--out", tmp_path / "out")
    assert "there is no such folder" in refused(3, "fleet", tmp_path / "elsewhere", "--out", tmp_path / "out")
    assert "cannot be written to" in refused(2, "fleet", good, "--out", tmp_path / "fleet.toml")
    assert run("fleet", "--out", tmp_path / "out").exit_code == 2


@pytest.mark.slow
def test_campaigns_are_lent_to_processes_with_the_same_results(run, units, tmp_path):
    """Truth: the same fleet in this process, which leaves the campaigns' own reports and links to them."""
    out = tmp_path / "here"
    assert run("fleet", *units, "--out", out, "--workers", 1).exit_code == 0
    assert {"estimate.json", "mechanism.toml", "report.html"} <= {p.name for p in (out / "units" / "FM1").iterdir()}
    assert 'href="units/FM1/report.html"' in (out / "fleet.html").read_text(encoding="utf-8")
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as executor:
        mechid.fleet(*units, out=tmp_path / "lent", executor=executor)
    for unit in ("FM1", "FM2"):
        here, lent = (estimate(tmp_path / name, unit)["parameters"] for name in ("here", "lent"))
        assert lent == here
