"""Structure files with bytes changed, or of a kind that never ends. Truth: a structure or one line, never a crash."""

import os

import numpy as np
import pytest
from scipy.io import savemat

from mechid.errors import InputFileError
from mechid.structure import Location, Selection, read_structure
from mechid.structure.nastran import refuse_other_files
from three_modes import DAMPING, FREQUENCY_HZ, INTERFACE, LINE_OF_SIGHT, NAMES

DAMAGES = 60
SELECTION = Selection(interface=Location(3, "rz"), line_of_sight={"los_x": (Location(1, "rx"),)})
CONTENT = {"frequency_hz": FREQUENCY_HZ, "damping": DAMPING, "interface": INTERFACE, "line_of_sight": LINE_OF_SIGHT}


def modes_mat(path):
    savemat(path, CONTENT | {"line_of_sight_names": np.array(NAMES, dtype=object)})


def answer(path):
    """Return the structure, or None where there is one line that names the file."""
    try:
        return read_structure(path)
    except InputFileError as error:
        assert str(error).startswith(path.name)  # noqa: PT017
        assert "\n" not in str(error)  # noqa: PT017
        return None


def test_a_damaged_mat_file_is_a_structure_or_one_line(tmp_path):
    path = tmp_path / "modes.mat"
    modes_mat(path)
    whole = path.read_bytes()
    rng = np.random.default_rng(11)
    answers = []
    for _ in range(DAMAGES):
        damaged = bytearray(whole)
        for place in rng.integers(0, len(whole), 3):
            damaged[place] = rng.integers(0, 256)
        path.write_bytes(damaged)
        answers.append(answer(path))
    assert answers.count(None) > DAMAGES // 20
    path.write_bytes(whole)
    np.testing.assert_array_equal(read_structure(path).model.frequency_hz, FREQUENCY_HZ)


OTHERS = {
    "words for frequencies": {"frequency_hz": "fast"},
    "a cell for shapes": {"line_of_sight": np.array([[1.0], "a"], dtype=object)},
    "a struct for damping": {"damping": {"a": 1.0}},
    "nothing at all": {"frequency_hz": np.zeros(0), "interface": np.zeros(0), "line_of_sight": np.zeros((2, 0))},
    "empty names": {"line_of_sight_names": np.array([np.zeros(0), np.zeros(0)], dtype=object)},
}


@pytest.mark.parametrize("changes", OTHERS.values(), ids=OTHERS)
def test_a_mat_file_of_something_else_is_one_line(changes, tmp_path):
    savemat(tmp_path / "modes.mat", CONTENT | changes)
    assert answer(tmp_path / "modes.mat") is None


@pytest.mark.parametrize("suffix", [".mat", ".uff", ".op4", ".csv", ".toml"])
@pytest.mark.parametrize("what", ["a pipe", "a device"])
def test_what_is_no_file_is_said_at_once(what, suffix, tmp_path):
    path = tmp_path / f"modes{suffix}"
    os.mkfifo(path) if what == "a pipe" else path.symlink_to("/dev/zero")
    with pytest.raises(InputFileError) as caught:
        read_structure(path, SELECTION)
    assert str(caught.value) == f"modes{suffix}: cannot be read (it is {what}, not a file); check the path"


@pytest.mark.parametrize("suffix", [".csv", ".toml"])
def test_a_text_that_is_too_long_is_refused(suffix, tmp_path):
    path = tmp_path / f"modes{suffix}"
    with path.open("wb") as file:
        file.truncate(2**40)
    with pytest.raises(InputFileError, match="it is larger than 64 MiB"):
        read_structure(path)


@pytest.mark.parametrize("line", ["INCLUDE '/etc/hostname'", "  include 'other.asm'"])
def test_bulk_data_that_name_another_file_are_refused(tmp_path, line):
    """Truth: no number of another file comes in; pyYeti by itself follows such a line."""
    path = tmp_path / "s.asm"
    path.write_text(f"$ ASSEMBLY\nGRID,3,0,1.,2.,3.\n{line}\n")
    with pytest.raises(InputFileError, match=r"s\.asm: line 3: .*copy their lines here"):
        refuse_other_files(path)
    path.write_text("$ ASSEMBLY\nGRID,3,0,1.,2.,3.\n$ include no more\n")
    refuse_other_files(path)
    refuse_other_files(tmp_path / "no.pch")
