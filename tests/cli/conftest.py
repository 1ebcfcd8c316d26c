"""A small synthetic campaign, made once, and copies of it in which a test changes one thing."""

import json
import shutil

import pytest
from typer.testing import CliRunner

import chores
from fewer_records import keep_records
from mechid.campaign import mechanism_text
from mechid.campaign.bench import true_mechanism, write_bench
from mechid.cli.app import app
from mechid.identification.computation.workforce import working_on
from mechid.reports import into_folder
from once import once

STAGE = """
[[stage]]
records = ["full_46"]
window_s = [0.0, 0.05]
free = ["gear.stiffness", "gear.damping"]
"""

TWO = ("housing.gain", "housing.damping")
STAGE_OF_TWO = f"""
[[stage]]
records = ["full_46"]
window_s = [0.0, 0.3]
free = {json.dumps(TWO)}
"""


@pytest.fixture
def run():
    """Return a function that runs mechid with arguments, as the shell would."""

    def invoke(*arguments):
        return CliRunner().invoke(app, [str(argument) for argument in arguments], prog_name="mechid")

    return invoke


@pytest.fixture
def without_reports(monkeypatch):
    """Leave reports and figures away, which take most of the time; test_identify.py and test_report.py have them."""
    monkeypatch.setattr(into_folder, "_report", lambda *_, **__: [])
    monkeypatch.setattr(into_folder.Illustration, "begin", lambda *_: None)


@pytest.fixture
def lent(run, tmp_path):
    """Return a function that runs a command in threads and with its work lent out, and compares files of both.

    Lent out, function, tasks and results are pickled, and nothing that this process has worked out is there.
    """

    def compare(*arguments, files, least):
        recorded = chores.Recorded(2)
        here = run(*arguments, "--out", tmp_path / "here")
        assert here.exit_code == 0, here.stderr
        with working_on(recorded):
            there = run(*arguments, "--out", tmp_path / "there")
        assert there.exit_code == 0, there.stderr
        assert len(recorded.calls) >= least
        for name in files:
            assert (tmp_path / "there" / name).read_bytes() == (tmp_path / "here" / name).read_bytes(), name

    return compare


@pytest.fixture
def refused(run):
    """Return a function that runs mechid, expects an exit code and one line on stderr, and returns it."""

    def refuse(code, *arguments):
        result = run(*arguments)
        lines = [line for line in result.stderr.splitlines() if line.startswith("mechid: ")]
        assert result.exit_code == code, result.stderr
        assert len(lines) == 1, result.stderr
        assert "Traceback" not in result.stderr
        return lines[0]

    return refuse


@pytest.fixture(scope="session")
def bench(tmp_path_factory):
    """Return the folder of a bench whose sweep takes 1 s; not to be changed."""
    folder = tmp_path_factory.mktemp("bench")
    write_bench(folder, seed=3, sweep_s=1.0)
    return folder


@pytest.fixture
def folder(bench, tmp_path):
    """Return a copy of the bench's folder."""
    return shutil.copytree(bench, tmp_path / "bench")


@pytest.fixture
def changed(folder):
    """Return a function that replaces text in one of the folder's files."""

    def change(name, old, new):
        path = folder / name
        content = path.read_text(encoding="utf-8")
        assert content.count(old) >= 1, f"{old!r} is not in {name}"
        path.write_text(content.replace(old, new, 1), encoding="utf-8")
        return folder

    return change


@pytest.fixture
def staged(changed, folder):
    """Return the folder, its mechanism at the truth but for the gear, two records and a short stage that fits it."""
    keep_records(folder, "full_46", "micro_46")
    for old, new in (
        ("value = 9.5,", "value = 9.9,"),
        ("value = 0.0229", "value = 0.045"),
        ("value = 0.277", "value = 0.384"),
        ("value = 0.01,", "value = 0.0047,"),
        ("phase_deg = { value = 0.0,", "phase_deg = { value = 35.0,"),
        ("amplitude = { value = 0.0,", "amplitude = { value = 0.0231,"),
        ("phase_deg = { value = 0.0,", "phase_deg = { value = -110.0,"),
        ("value = 0.03,", "value = 0.008,"),
        ("value = 0.0265", "value = 0.0013"),
        ("value = 0.000974", "value = 0.0061"),
        ("value = 2200.0", "value = 1000.0"),
        ("value = 2.0,", "value = 4.6,"),
        ("value = 5000.0,", "value = 5578.0,"),
        ("value = 0.05,", "value = 0.095,"),
    ):
        changed("mechanism.toml", old, new)
    path = folder / "campaign.toml"
    path.write_text(path.read_text(encoding="utf-8") + STAGE, encoding="utf-8")
    return folder


def free_two(folder, *names):
    """Let a bench's campaign have the named records and two unknowns, fitted in a short stage; return its file."""
    keep_records(folder, *names)
    (folder / "mechanism.toml").write_text(mechanism_text(true_mechanism().with_free(TWO), "near"), encoding="utf-8")
    campaign = folder / "campaign.toml"
    campaign.write_text(campaign.read_text(encoding="utf-8") + STAGE_OF_TWO, encoding="utf-8")
    return campaign


@pytest.fixture(scope="session")
def bench_of_two(bench, tmp_path_factory):
    """Return a function that copies the bench and leaves it the named records and two unknowns."""

    def copy(*names):
        folder = shutil.copytree(bench, tmp_path_factory.mktemp("two") / "bench")
        free_two(folder, *names)
        return folder

    return copy


@pytest.fixture(scope="session")
def fitted(tmp_path_factory):
    """Return the folders of a campaign of two records and two unknowns, and of its fit; not to be changed."""

    def make():
        folder = tmp_path_factory.mktemp("beyond")
        write_bench(folder / "bench", seed=3, sweep_s=1.0)
        campaign = free_two(folder / "bench", "full_46", "micro_46")
        result = CliRunner().invoke(app, ["identify", str(campaign), "--out", str(folder / "fit")])
        assert result.exit_code == 0, result.stderr
        return folder

    return once(tmp_path_factory, "fit_of_two", make)
