"""Files that are there whole or as they were; truth: what stood there before."""

import pytest

from mechid.command.rate_table import read_rate_table
from mechid.errors import UsageError
from mechid.records.formats import open_table
from mechid.structure.formats import read_structure
from mechid.writing import creating_folder, protect_read_files, write_atomically, write_together


def test_a_file_is_as_it_was_where_writing_fails(tmp_path):
    path = tmp_path / "record.csv"
    path.write_text("before")

    def rows():
        yield "half"
        raise ValueError("lost")

    with pytest.raises(ValueError, match="lost"):
        write_atomically(path, rows())
    assert path.read_text() == "before"
    assert list(tmp_path.iterdir()) == [path]
    write_atomically(path, ["a\n", "b\n"])
    assert path.read_bytes() == b"a\nb\n"


def test_several_files_are_replaced_when_all_are_whole(tmp_path):
    folder = tmp_path / "made" / "with parents"
    assert write_together(folder, {"a.json": "1", "b.csv": "2"}) == [folder / "a.json", folder / "b.csv"]
    with pytest.raises(UnicodeEncodeError):
        write_together(folder, {"a.json": "3", "b.csv": "\ud800"})
    assert {path.name: path.read_text() for path in folder.iterdir()} == {"a.json": "1", "b.csv": "2"}


def test_the_first_file_named_is_the_first_to_be_replaced(tmp_path):
    """Truth: a folder that stands in the second one's place stops that one alone."""
    (tmp_path / "b.csv").mkdir()
    with pytest.raises(UsageError, match=r"cannot be written to \(.+\); give another folder$"):
        write_together(tmp_path, {"a.json": "1", "b.csv": "2"})
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.json", "b.csv"]


def test_a_folder_that_cannot_be_made_is_the_users_error(tmp_path):
    (tmp_path / "file").write_text("")
    refused = pytest.raises(UsageError, match=r"file/x: cannot be written to \(.+\); give another folder$")
    with refused, creating_folder(tmp_path / "file" / "x"):
        raise AssertionError("not reached")


READ = {
    "a record": (lambda path: open_table(path, path.name), "time_s,torque_Nm\n0.0,1.0\n0.1,2.0\n"),
    "a table of rates": (read_rate_table, "time_s,rate\n0.0,1.0\n0.1,2.0\n"),
    "a structure": (
        read_structure,
        "frequency_Hz,los_x_re [rad/(N*m)],los_x_im [rad/(N*m)]\n1.0,1.0,0.0\n2.0,1.0,0.0\n3.0,1.0,0.0\n",
    ),
}


@pytest.mark.parametrize("kind", READ)
def test_what_a_command_has_read_no_result_of_it_replaces(tmp_path, kind):
    """Truth: the file's bytes; outside the command, as in a notebook, it is written."""
    read, text = READ[kind]
    path = tmp_path / "bootstrap.csv"
    path.write_text(text)
    with protect_read_files():
        read(path)
        with pytest.raises(UsageError, match=r"bootstrap.csv: is one of the files that were read, and is not replaced"):
            write_together(tmp_path, {"bootstrap.csv": "result"})
        assert path.read_text() == text
    write_together(tmp_path, {"bootstrap.csv": "result"})
    assert path.read_text() == "result"
