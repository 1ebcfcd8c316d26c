"""Names that no file can have, and standard streams as shells leave them. Truth: the exit codes of the contract."""

import os
import shutil
import subprocess
import sys

import pytest

from mechid.budgets.example import write_example

LONG = "x" * 300
ENDLESS = "x" * 5000


@pytest.mark.parametrize(
    "arguments",
    [
        ["simulate", "bench"],
        ["identify", "bench"],
        ["look", "bench/full_46.csv"],
        ["check", "bench"],
        ["demo"],
        ["fleet", "bench"],
        ["design", "bench"],
        ["export", "fit", "--to", "c"],
        ["diagnose", "fit"],
        ["profile", "fit", "--parameter", "housing.gain"],
        ["bootstrap", "fit"],
    ],
    ids=lambda arguments: arguments[0],
)
def test_an_output_folder_of_300_letters_is_2(refused, fitted, tmp_path, arguments):
    told = [fitted / one if one.startswith(("bench", "fit")) else one for one in arguments]
    line = refused(2, *told, "--out", tmp_path / LONG)
    assert "name" in line
    assert "too long" in line
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "arguments",
    [
        ["new"],
        ["report"],
        ["explore", "--no-browser"],
        ["kernel", "--mechanism"],
        ["diagnose", "--out", "out"],
        ["export", "--to", "c", "--out", "out"],
        ["fleet", "--out", "out"],
        ["compare", "x"],
    ],
    ids=lambda arguments: arguments[0],
)
@pytest.mark.parametrize("name", [LONG, ENDLESS])
def test_a_name_that_no_file_can_have_is_one_line(run, tmp_path, monkeypatch, arguments, name):
    monkeypatch.chdir(tmp_path)
    result = run(*arguments, name)
    assert result.exit_code in (2, 3)
    assert isinstance(result.exception, SystemExit)
    assert len(result.stderr) < 1000


@pytest.mark.parametrize("suffix", [".csv", ".h5", ".mat", ""])
def test_a_record_of_5000_letters_is_4(refused, changed, suffix):
    line = refused(4, "check", changed("campaign.toml", '"full_46.csv"', f'"{ENDLESS}{suffix}"'))
    assert len(line) < 1000


@pytest.mark.parametrize("name", [ENDLESS, f"{ENDLESS}.toml", f"{ENDLESS}.op2"])
def test_a_structure_of_5000_letters_is_3(refused, fitted, tmp_path, name):
    folder = shutil.copytree(fitted / "fit", tmp_path / "fit")
    write_example(folder)
    budget = folder / "budget.toml"
    budget.write_text(budget.read_text().replace('file = "structure.toml"', f'file = "{name}"'))
    line = refused(3, "budget", budget, "--out", tmp_path / "out")
    assert "structure.file" in line or "xxx" in line
    assert len(line) < 1000


def run_as_shell(*arguments, **how):
    return subprocess.run([sys.executable, "-m", "mechid", *map(str, arguments)], check=False, text=True, **how)


@pytest.fixture
def two_fits(fitted, tmp_path):
    """Return the folders of two equal fits, which are compared within a second."""
    return fitted / "fit", shutil.copytree(fitted / "fit", tmp_path / "other")


def closing(number):
    return {"preexec_fn": lambda: os.close(number), "stderr" if number == 1 else "stdout": subprocess.PIPE}


def test_closed_standard_output_is_as_if_nobody_had_asked_for_it(two_fits):
    assert run_as_shell("compare", *two_fits, **closing(1)).returncode == 0
    missing = run_as_shell("compare", two_fits[0], two_fits[1] / "none.json", **closing(1))
    assert missing.returncode == 3
    assert len(missing.stderr.splitlines()) == 1


def test_closed_standard_error_takes_nothing_away(two_fits):
    done = run_as_shell("compare", *two_fits, **closing(2))
    assert done.returncode == 0
    assert "do not separate the hypotheses" in done.stdout
    assert run_as_shell("compare", two_fits[0], two_fits[1] / "none.json", **closing(2)).returncode == 3


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="has no /dev/full")  # noqa: PTH110
def test_full_standard_output_is_2_in_one_line(two_fits):
    with open("/dev/full", "w") as full:  # noqa: PTH123
        for arguments in (["compare", *two_fits], ["--help"], ["kernel"]):
            done = run_as_shell(*arguments, stdout=full, stderr=subprocess.PIPE)
            said = [line for line in done.stderr.splitlines() if line.startswith("mechid")]
            assert said == ["mechid: error: standard output: cannot be written to (No space left on device)"]
            assert done.returncode == 2
            assert "Traceback" not in done.stderr
        assert run_as_shell("kernel", stdout=subprocess.PIPE, stderr=full).returncode == 0


def test_a_reader_that_has_gone_is_quiet(fitted):
    """Truth: 141 is what a shell says of a tool that SIGPIPE ends, as of `yes | head -1`."""
    reading, writing = os.pipe()
    os.close(reading)
    with os.fdopen(writing, "w") as pipe:
        done = run_as_shell("kernel", stdout=pipe, stderr=subprocess.PIPE)
    assert done.returncode == 141
    assert [line for line in done.stderr.splitlines() if not line.startswith(("kernel loaded", "its source"))] == []


ASCII = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "PYTHONIOENCODING": "ascii"}


def test_a_path_of_umlauts_is_written_to_where_letters_are_ascii(fitted, tmp_path):
    """Truth: the bytes of the names, UTF-8, which the results hold."""
    fit, out = shutil.copytree(fitted / "fit", tmp_path / "Prüfstand"), tmp_path / "größe"
    how = {"env": {**os.environ, **ASCII}, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    done = run_as_shell("export", fit, "--to", "linear", "--out", out, **how)
    assert done.returncode == 0, done.stderr
    for name in ("mechid_export.json", "mechid_export.html", "linear.json"):
        assert (out / name).read_bytes().decode("utf-8")
    missing = run_as_shell("check", fit / "ähnlich.toml", **how)
    assert missing.returncode == 3
    assert len(missing.stderr.splitlines()) == 1


@pytest.mark.slow
def test_a_path_of_umlauts_is_identified_from_where_letters_are_ascii(bench_of_two, tmp_path):
    """Truth: the bytes of the names, UTF-8, which the results hold."""
    folder = bench_of_two("full_46", "micro_46").rename(tmp_path / "Prüfstand")
    out = tmp_path / "größe"
    how = {"env": {**os.environ, **ASCII}, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    assert run_as_shell("check", folder, **how).returncode == 0
    done = run_as_shell("identify", folder, "--out", out, **how)
    assert done.returncode == 0, done.stderr
    assert "unexpected" not in done.stderr
    assert "warning: no report" not in done.stderr
    for path in (out / "report.html", out / "estimate.json", out / "journal.jsonl"):
        assert path.read_bytes().decode("utf-8")
    assert run_as_shell("report", out, **how).returncode == 0
