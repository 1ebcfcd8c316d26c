"""The command's verbs and exit codes. Truth: the contract of exit codes (docs/commands.md), and the loaded modules."""

import subprocess
import sys
from importlib.metadata import version

import pytest

import mechid


def test_the_version_is_that_of_the_package(run):
    assert run("--version").stdout == f"mechid {version('mechid')}\n"
    assert mechid.__version__ == version("mechid")


HELP = """
import sys
sys.argv = ["mechid", "--help"]
from mechid.cli import main
try:
    main()
finally:
    print(*sys.modules, sep="\\n")
"""


def test_help_imports_nothing_heavy():
    """Measured 0.25 s; what it must not import takes more than a second."""
    result = subprocess.run([sys.executable, "-c", HELP], capture_output=True, text=True, check=True)
    assert "identify" in result.stdout
    assert not {"bokeh", "jinja2", "matplotlib", "numba", "numpy", "pint", "scipy", "sympy"} & set(
        result.stdout.splitlines()
    )


@pytest.mark.parametrize(
    "arguments",
    [
        ["simulate", "campaign.toml"],
        ["identify", "campaign.toml"],
        ["identify", "campaign.toml", "--out", "x", "--workers", "0"],
        ["identify", "campaign.toml", "--out", "x", "--seed", "one"],
        ["simulate", "campaign.toml", "--out", "x", "--rate", "3"],
        ["kernel", "--lanes", "-1"],
        ["idenify"],
        [],
    ],
)
def test_a_wrong_command_line_is_2(run, arguments):
    result = run(*arguments)
    assert result.exit_code == 2
    assert "Traceback" not in result.stderr
    assert "Usage: mechid" in result.output


def test_an_unexpected_error_is_1_with_one_line(monkeypatch, capsys):
    from mechid.cli import app

    def broken():
        raise ZeroDivisionError("division\nby zero")

    monkeypatch.setattr(app, "app", broken)
    monkeypatch.setattr(app, "prepare_streams", lambda: None)  # those of the test stay
    monkeypatch.delenv("MECHID_DEBUG", raising=False)
    with pytest.raises(SystemExit) as exit_:
        app.main()
    assert exit_.value.code == 1
    assert capsys.readouterr().err.splitlines() == [
        "mechid: unexpected error, please report it (with the traceback that MECHID_DEBUG=1 shows): "
        "ZeroDivisionError: division by zero"
    ]
    monkeypatch.setenv("MECHID_DEBUG", "1")
    with pytest.raises(ZeroDivisionError):
        app.main()
