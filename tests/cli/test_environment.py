"""No compiler, no memory, no working directory, Ctrl-C at once. Truth: the exit codes of the contract."""

import subprocess
import sys

import pytest

from mechid.cli import main
from mechid.cli.environment import refuse_surroundings


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("NUMBA_DISABLE_JIT", "1", "NUMBA_DISABLE_JIT is set, and mechid's equations only run compiled; unset it"),
        ("NUMBA_NUM_THREADS", "0", "NUMBA_NUM_THREADS is 0; unset it, or give 1 or more"),
        ("NUMBA_NUM_THREADS", "-1", "NUMBA_NUM_THREADS is -1; unset it, or give 1 or more"),
    ],
)
def test_an_environment_in_which_nothing_compiles_is_2(refused, folder, monkeypatch, name, value, said):
    monkeypatch.setenv(name, value)
    assert said in refused(2, "check", folder)


def test_what_numba_passes_over_is_passed_over():
    refuse_surroundings({"NUMBA_DISABLE_JIT": "0", "NUMBA_NUM_THREADS": "many"})
    refuse_surroundings({"NUMBA_DISABLE_JIT": "", "NUMBA_NUM_THREADS": ""})


@pytest.mark.skipif(sys.platform == "win32", reason="Windows does not remove the folder that a process is in")
def test_a_working_directory_that_is_gone_is_2(folder, tmp_path):
    script = f"import os, sys; os.chdir({str(tmp_path / 'gone')!r}); os.rmdir(os.getcwd()); "
    script += f"sys.argv = ['mechid', 'check', {str(folder)!r}]; from mechid.cli import main; main()"
    (tmp_path / "gone").mkdir()
    done = subprocess.run([sys.executable, "-c", script], check=False, capture_output=True, text=True)
    assert done.returncode == 2
    assert done.stderr == "mechid: error: the folder in which this was started is gone; change to another one\n"


def test_no_memory_is_2(refused, folder, monkeypatch):
    def fails(*_, **__):
        raise MemoryError

    monkeypatch.setattr("mechid.checks.run.check", fails)
    assert "not enough memory for this" in refused(2, "check", folder)


def test_ctrl_c_while_the_command_loads_is_130(monkeypatch, capsys):
    def interrupted():
        raise KeyboardInterrupt

    monkeypatch.setattr("mechid.cli.app.main", interrupted)
    monkeypatch.setattr("mechid.cli.termination.listen_for_signals", lambda: None)  # the tests keep theirs
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 130
    assert capsys.readouterr().err == "mechid: interrupted\n"
