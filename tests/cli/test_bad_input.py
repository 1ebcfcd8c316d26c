"""Each bad input of the user ends in one line that says what is wrong, and in its own exit code.

Truth: the contract of exit codes (docs/commands.md), case by case below.
"""

import os
import time

import numpy as np
import pytest

import hostile_files
from instrument_files import FORMATS

MECHANISM, CAMPAIGN = "mechanism.toml", "campaign.toml"

WRONG_FILES = [
    ("unknown key", MECHANISM, "stiffness =", "stifness =", 'did you mean "stiffness"?'),
    ("a period of nothing", MECHANISM, "period_deg = 1.8", "period_deg = 1e-320", "found 1e-320; write degrees"),
    ("a mechanism of 5000 letters", CAMPAIGN, '"mechanism.toml"', f'"{"m" * 5000}.toml"', "mmm..."),
    ("unit-like text", MECHANISM, "rotor_inertia = 8.9e-06", 'rotor_inertia = "8.9e-6 kg m2"', "without quotes"),
    ("wrong type", MECHANISM, "rotor_inertia = 8.9e-06", "rotor_inertia = true", "found true"),
    ("value outside its bounds", MECHANISM, "value = 9.5,", "value = 95.0,", "is above max = 20"),
    ("min above max", MECHANISM, "min = 5.0, max = 20.0", "min = 20.0, max = 5.0", "min = 20 is above max = 5"),
    ("two records of one name", CAMPAIGN, 'name = "full_92"', 'name = "full_23"', "full_23"),
    ("no toml", CAMPAIGN, "[[record]]", "[[record]", "campaign.toml: line"),
    ("mechanism file missing", CAMPAIGN, '"mechanism.toml"', '"mechanisms.toml"', "there is no such file"),
    (
        "unknown parameter in a stage",
        CAMPAIGN,
        'mechanism = "mechanism.toml"',
        'mechanism = "mechanism.toml"\nstage = [{ free = ["gear.stifness"] }]',
        'did you mean "gear.stiffness"?',
    ),
]


@pytest.mark.parametrize(
    ("name", "old", "new", "says"), [row[1:] for row in WRONG_FILES], ids=[r[0] for r in WRONG_FILES]
)
@pytest.mark.parametrize("verb", ["check", "identify"])
def test_a_wrong_mechanism_or_campaign_file_is_3(refused, changed, tmp_path, name, old, new, says, verb):
    arguments = [verb, changed(name, old, new), *(["--out", tmp_path / "out"] if verb == "identify" else [])]
    line = refused(3, *arguments)
    assert line.startswith("mechid: error: ")
    assert says in line


def test_a_missing_campaign_is_3(refused, tmp_path):
    assert "there is no such file" in refused(3, "check", tmp_path / "campaign.toml")
    assert "mechid new" in refused(3, "check", tmp_path)


def test_a_file_of_another_kind_is_named_as_what_it_is(refused, folder):
    assert "mechanism.toml: is a mechanism file; give a campaign file" in refused(3, "check", folder / MECHANISM)
    assert "campaign.toml: is a campaign file; give a mechanism file" in refused(3, "kernel", folder / CAMPAIGN)
    line = refused(3, "budget", folder / CAMPAIGN, "--out", folder / "out")
    assert "campaign.toml: is a campaign file; give a budget file" in line


def test_a_table_that_stands_twice_is_told_to_be_kept_once(refused, changed):
    folder = changed(MECHANISM, "[load]", "[gear]\nratio = 50\n[load]")
    line = refused(3, "check", folder)
    assert "twice, in '[gear]'; the name is there already: keep one" in line


def test_equations_in_two_forms_at_once_are_2(refused):
    assert "--source, --latex: give one of them" in refused(2, "kernel", "--source", "--latex")


WRONG_RECORDS = {
    "missing": (None, 'did you mean "full_46.csv"?'),
    "empty": (lambda lines: lines[:1], "no samples"),
    "time goes back": (lambda lines: [*lines[:51], lines[49], *lines[52:]], "line 52"),
    "repeated time": (lambda lines: [*lines[:51], lines[50], *lines[52:]], "line 52"),
    "not a number": (lambda lines: [*lines[:51], "0.005,nan", *lines[52:]], "nan"),
}


@pytest.mark.parametrize("kind", WRONG_RECORDS)
@pytest.mark.parametrize("verb", ["check", "simulate", "identify"])
def test_a_record_that_cannot_be_used_is_4(refused, folder, tmp_path, kind, verb):
    spoil, says = WRONG_RECORDS[kind]
    path = folder / "full_46.csv"
    if spoil is None:
        path.rename(folder / "full_46x.csv")
        says = "there is no such file"
    else:
        path.write_text("\n".join(spoil(path.read_text().splitlines())) + "\n")
    line = refused(4, verb, folder, *(["--out", tmp_path / "out"] if verb != "check" else []))
    assert "full_46.csv" in line
    assert says in line


NO_FILES = {"a device": lambda path: path.symlink_to("/dev/zero"), "a pipe": os.mkfifo}


def becomes(path, what):
    path.unlink(missing_ok=True)
    NO_FILES[what](path)


@pytest.mark.parametrize("what", NO_FILES)
@pytest.mark.parametrize("name", [MECHANISM, CAMPAIGN, "rates.csv", "grease.py"])
def test_a_text_that_never_ends_is_3_at_once(refused, changed, folder, what, name):
    if name == "rates.csv":
        changed(CAMPAIGN, "rate = 46.0", 'rate_table = "rates.csv"')
    if name == "grease.py":
        changed(MECHANISM, "[friction]", '[friction]\nblock = "grease.py:grease"')
    becomes(folder / name, what)
    began = time.perf_counter()
    line = refused(3, "check", folder / CAMPAIGN)
    assert name in line
    assert f"cannot be read (it is {what}, not a file)" in line
    assert time.perf_counter() - began < 10.0


@pytest.mark.parametrize("name", [MECHANISM, CAMPAIGN])
def test_a_text_that_is_too_long_is_3(refused, folder, name):
    with (folder / name).open("r+b") as file:
        file.truncate(2**33)
    assert f"{name}: cannot be read (it is larger than 64 MiB)" in refused(3, "check", folder)


@pytest.mark.parametrize("what", NO_FILES)
@pytest.mark.parametrize("suffix", [".csv", ".mat", ".h5"])
def test_a_record_that_is_no_file_is_4(refused, changed, folder, what, suffix):
    changed(CAMPAIGN, '"full_46.csv"', f'"full_46{suffix}"')
    becomes(folder / f"full_46{suffix}", what)
    assert f"full_46{suffix}: cannot be read: it is {what}, not a file" in refused(4, "check", folder)
    assert f"it is {what}, not a file" in refused(4, "check", folder / f"full_46{suffix}")


@pytest.mark.parametrize("verb", ["check", "identify", "look"])
def test_numbers_of_another_file_are_4(refused, changed, folder, tmp_path, verb):
    pytest.importorskip("h5py")
    hostile_files.other(folder)
    name = hostile_files.written(folder / "full_46.h5", hostile_files.raw_storage)
    changed(CAMPAIGN, '"full_46.csv"', '"full_46.h5"\nchannels = [{ quantity = "torque", column = "x" }]')
    line = refused(4, verb, folder, *([] if verb == "check" else ["--out", tmp_path / "out"]))
    assert 'column "x": its numbers are those of another file; ' in line
    assert f'external_files = ["{name}"]' in line


def test_numbers_of_another_file_are_read_where_the_campaign_allows_it(run, changed, folder):
    pytest.importorskip("h5py")
    hostile_files.other(folder)
    hostile_files.written(folder / "full_46.h5", hostile_files.raw_storage)
    changed(CAMPAIGN, '"full_46.csv"', '"full_46.h5"\nchannels = [{ quantity = "torque", column = "x" }]')
    changed(CAMPAIGN, '"full_46.h5"', '"full_46.h5"\nexternal_files = ["raw.bin"]')
    result = run("check", folder)
    assert result.exit_code == 0, result.stderr
    assert "takes numbers from raw.bin, which its digest does not cover" in " ".join(result.stdout.split())


@pytest.mark.parametrize("entry", ['"raw.bin"', "[1]", "[]"])
def test_external_files_are_a_list_of_names(refused, changed, entry):
    folder = changed(CAMPAIGN, '"full_46.csv"', f'"full_46.csv"\nexternal_files = {entry}')
    assert 'external_files = ["part_1.h5"]' in refused(3, "check", folder)


def test_a_file_that_crashes_its_reader_is_4(refused, changed, folder):
    """Truth: bytes on which SciPy 1.17 ends in a segmentation fault (tests/records/test_matlab.py)."""
    FORMATS["mat 5"].write(folder / "full_46.mat")
    content = bytearray((folder / "full_46.mat").read_bytes())
    content[401], content[264] = 202, 21
    (folder / "full_46.mat").write_bytes(content)
    changed(CAMPAIGN, '"full_46.csv"', '"full_46.mat"')
    assert "full_46.mat: is cut off, damaged, or not a" in refused(4, "check", folder)


@pytest.mark.parametrize("name", FORMATS)
def test_a_file_cut_anywhere_is_listed_or_4(run, tmp_path, name):
    """Truth: half a file is not the file; the readers' tests hold what is read against what was written."""
    path = tmp_path / FORMATS[name].name
    FORMATS[name].write(path)
    whole = path.read_bytes()
    for end in np.random.default_rng(5).integers(0, len(whole) - 1, 10):
        path.write_bytes(whole[:end])
        result = run("check", path)
        assert result.exit_code in (0, 4), result.stderr
        assert len(result.stderr.splitlines()) == (result.exit_code == 4)
        assert result.exception is None or isinstance(result.exception, SystemExit)


def test_a_folder_that_cannot_be_made_is_2(refused, staged, tmp_path):
    (tmp_path / "file").write_text("")
    assert "cannot be written to" in refused(2, "simulate", staged, "--out", tmp_path / "file" / "x")
    assert "cannot be written to" in refused(2, "identify", staged, "--out", tmp_path / "file" / "x")
    assert "cannot be written to" in refused(2, "new", tmp_path / "file" / "x")


def test_a_mechanism_that_diverges_is_5_and_leaves_no_file(refused, changed, tmp_path):
    folder = changed("mechanism.toml", "inertia = 0.010534", "inertia = 1e-9")
    line = refused(5, "simulate", folder, "--out", tmp_path / "out")
    assert 'record "full_23" at ' in line
    assert "mechanism file" in line
    assert not (tmp_path / "out").exists()


def test_nothing_to_estimate_is_5(refused, campaign_folder, tmp_path):
    line = refused(5, "identify", campaign_folder / "exact", "--out", tmp_path / "out")
    assert "no parameter to estimate" in line
