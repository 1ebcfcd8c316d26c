"""What a user has is never replaced by what a command makes, and a command leaves all of its files or none.

Truth: the files' own bytes before and after, and the contract of exit codes (docs/commands.md).
"""

import errno
import os

import pytest
from typer.testing import CliRunner

import mechid.writing
from mechid.budgets.example import write_example
from mechid.cli.app import app
from paper_estimate import write_estimate_of_paper


@pytest.fixture
def budget_file(tmp_path):
    write_estimate_of_paper(tmp_path, fit_percent=99.0)
    return write_example(tmp_path)[0]


def content(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


def test_simulated_records_never_replace_measured_ones(refused, folder):
    before = content(folder)
    assert "holds full_23.csv, which is no simulation of mechid" in refused(2, "simulate", folder, "--out", folder)
    assert content(folder) == before


def test_a_bench_never_replaces_a_campaign_that_is_none(refused, folder):
    (folder / "truth.json").unlink()
    before = content(folder)
    assert "campaign.toml of measured records" in refused(2, "demo", "--out", folder)
    assert content(folder) == before


def test_an_estimate_beside_its_campaign_leaves_the_mechanism_as_it_was(run, staged):
    before = content(staged)
    result = run("identify", staged, "--out", staged)
    assert result.exit_code == 0, result.stderr
    after = content(staged)
    assert {name: after[name] for name in before} == before
    assert b"Estimated by mechid" in after["mechanism_estimated.toml"]


def test_simulated_records_are_all_there_or_none(refused, folder, tmp_path, monkeypatch):
    """Truth: a disk that is full at the third file."""
    write, count = mechid.writing._write, iter(range(9))

    def full(path, text):
        if next(count) == 2:
            raise OSError(28, "No space left on device")
        write(path, text)

    monkeypatch.setattr(mechid.writing, "_write", full)
    line = refused(2, "simulate", folder, "--out", tmp_path / "out")
    assert "cannot be written to (No space left on device); make room, or give another folder; nothing was" in line
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("verb", ["simulate", "design", "budget"])
def test_a_folder_that_is_a_file_is_told_before_the_work(refused, folder, tmp_path, budget_file, verb, monkeypatch):
    """Truth: nothing is simulated; the work would fail the test."""
    monkeypatch.setattr("mechid.budgets.run.make_budget", None)
    monkeypatch.setattr("mechid.designs.run.make_design", None)
    monkeypatch.setattr("mechid.simulations.run.simulate_all", None)
    out = tmp_path / "taken"
    out.write_text("mine")
    line = refused(2, verb, budget_file if verb == "budget" else folder, "--out", out / "deeper")
    assert f"{out / 'deeper'}: cannot be written to ({out} is a file); give another folder" in line
    assert out.read_text() == "mine"


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="needs rights that can be taken away")
def test_a_folder_without_right_to_write_is_2(refused, folder, tmp_path):
    locked = tmp_path / "locked"
    locked.mkdir(mode=0o500)
    assert "no permission" in refused(2, "simulate", folder, "--out", locked / "out")


def test_a_cache_that_cannot_be_written_is_2(refused, folder, tmp_path, monkeypatch):
    from mechid.kernel import compiled

    (tmp_path / "file").write_text("")
    compiled._kernel.cache_clear()
    monkeypatch.setenv("MECHID_CACHE", str(tmp_path / "file"))
    line = refused(2, "simulate", folder, "--out", tmp_path / "out")
    assert "the kernel cannot be kept there" in line
    assert "MECHID_CACHE" in line


def test_a_cache_that_is_full_is_2(refused, folder, tmp_path, monkeypatch):
    """Truth: what the compilation raises, in a thread of its own."""
    from mechid.kernel import compiled

    def full(*arguments):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    compiled._kernel.cache_clear()
    monkeypatch.setattr(compiled, "_compile", full)
    line = refused(2, "simulate", folder, "--out", tmp_path / "out")
    assert "the kernel cannot be kept there (No space left on device)" in line


def test_simulated_records_never_replace_those_of_another_campaign(run, refused, folder, tmp_path):
    """Truth: the other folder's bytes; what `simulate` has written itself it replaces."""
    other = tmp_path / "other"
    other.mkdir()
    (other / "full_23.csv").write_text("time_s,torque_Nm\n0.0,0.125\n0.0001,0.25\n")
    before = content(other)
    assert "holds full_23.csv, which is no simulation of mechid" in refused(2, "simulate", folder, "--out", other)
    assert content(other) == before
    for _ in range(2):
        assert run("simulate", folder, "--out", tmp_path / "out").exit_code == 0


@pytest.mark.slow
@pytest.mark.usefixtures("without_reports")
def test_an_estimate_in_another_folder_leaves_a_mechanism_written_there_by_hand(run, staged, tmp_path):
    """Truth: the file's bytes; the estimate has another name, which estimate.json tells, and is found there."""
    other = tmp_path / "other"
    other.mkdir()
    (other / "mechanism.toml").write_text("# by hand\n")
    for _ in range(2):
        assert run("identify", staged, "--out", other).exit_code == 0
    assert (other / "mechanism.toml").read_text() == "# by hand\n"
    assert b"Estimated by mechid" in (other / "mechanism_estimated.toml").read_bytes()
    assert run("export", other, "--to", "c", "--out", tmp_path / "c").exit_code == 0


CALLED = {"full_46": "bootstrap", "full_23": "profile", "micro_46": "fleet", "micro_92": "lines"}
"""Records, and the result after which the file of each is called."""


@pytest.fixture(scope="module")
def named(bench_of_two):
    """Return the folder of a campaign whose records' files are called as results are; its fit is in it."""
    folder = bench_of_two(*CALLED)
    text = (folder / "campaign.toml").read_text(encoding="utf-8")
    for record, result in CALLED.items():
        (folder / f"{record}.csv").rename(folder / f"{result}.csv")
        assert text.count(f'"{record}.csv"') == 1
        text = text.replace(f'"{record}.csv"', f'"{result}.csv"')
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
    assert CliRunner().invoke(app, ["identify", str(folder), "--out", str(folder / "fit")]).exit_code == 0
    return folder


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "words"),
    [
        pytest.param("bootstrap.csv", ("bootstrap", "FIT", "--draws", "2", "--out", "BENCH"), marks=pytest.mark.slow),
        ("profile.csv", ("profile", "FIT", "--parameter", "housing.gain", "--out", "BENCH")),
        pytest.param("fleet.csv", ("fleet", "BENCH", "--out", "BENCH"), marks=pytest.mark.slow),
        ("lines.csv", ("export", "FIT", "--to", "tables", "--option", "rates=46", "--out", "BENCH")),
    ],
)
def test_a_record_that_is_called_as_a_result_is_never_replaced(refused, named, name, words):
    bench = named
    places = {"FIT": bench / "fit", "BENCH": bench}
    before = content(bench)
    line = refused(2, *(places.get(word, word) for word in words))
    assert name in line
    assert "not replaced" in line
    assert {one: was for one, was in content(bench).items() if one in before} == before


def test_a_record_is_not_replaced_by_what_is_seen_in_it(refused, folder):
    (folder / "csv").mkdir()
    record = (folder / "full_46.csv").rename(folder / "csv" / "lines.csv")
    before = record.read_bytes()
    assert "lines.csv: is one of the files that were read" in refused(2, "look", record, "--out", folder)
    assert record.read_bytes() == before


def test_an_export_replaces_nothing_that_no_export_has_left(run, refused, fitted, tmp_path):
    """Truth: the bytes of a main.c by hand."""
    asked = ("export", fitted / "fit", "--campaign", fitted / "bench", "--out", tmp_path / "out", "--to", "c")
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "main.c").write_text("int main(void) { return 7; }\n")
    assert "holds main.c, which no export of mechid has left and is not replaced" in refused(2, *asked)
    assert content(tmp_path / "out") == {"main.c": b"int main(void) { return 7; }\n"}
    (tmp_path / "out" / "main.c").unlink()
    assert run(*asked).exit_code == 0


@pytest.mark.slow
def test_exports_of_two_targets_share_a_folder_and_are_made_again(run, fitted, tmp_path):
    """Truth: the contract of exit codes."""
    asked = ("export", fitted / "fit", "--campaign", fitted / "bench", "--out", tmp_path / "out", "--to")
    for target in (("c",), ("tables", "--option", "rates=46"), ("c",)):
        assert run(*asked, *target).exit_code == 0
