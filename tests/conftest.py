"""Fixtures that several layers' tests share, and the figures that measured data give."""

import os
import signal
from functools import lru_cache
from pathlib import Path

import pytest
import typer.testing

import golden_text
import measured_data
from measured_data import NAMED, Figure
from mechid.identification.stages import kernel_precompilation
from mechid.ink import pens

FIGURES = pytest.StashKey[list]()
WORKERS = "PYTEST_XDIST_WORKER_COUNT"


def pytest_addoption(parser):
    """Let a run keep anew what is compared with kept texts and fits."""
    what = "keep the generated kernels' texts, and with -m slow the complete fits, as they are made now"
    parser.addoption(golden_text.OPTION, action="store_true", help=what)


def pytest_configure():
    """Hear SIGINT also where a shell began the tests in the background: what they start would inherit deaf ears."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session", autouse=True)
def no_processes_beside():
    """Let no command start processes of its own for kernels ahead or figures where each core has a worker of the tests.

    Kernels ahead: from a cold cache such a process takes as long as the search itself, from the other worker, and is
    mostly killed before its kernels are needed. Figures: a third of a small identification is the start of two
    processes that draw; this one draws them as well. Their own tests have both.
    """
    with pytest.MonkeyPatch.context() as patched:
        if int(os.environ.get(WORKERS, "1")) >= kernel_precompilation.usable_cores():
            patched.setattr(kernel_precompilation, "usable_cores", lambda: 1)
            patched.setattr(pens, "MOST", 0)
        yield


@pytest.fixture(scope="session", autouse=True)
def one_command():
    """Let Typer build the command once: for each of a thousand calls it would inspect 20 functions again, 40 ms."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(typer.testing, "_get_command", lru_cache(typer.testing._get_command))
        yield


@pytest.fixture
def processes_that_draw(monkeypatch):
    """Let figures be drawn by processes beside this one, as outside of tests."""
    monkeypatch.setattr(pens, "MOST", 2)


@pytest.fixture(scope="session")
def campaign_folder():
    """Return the folder of campaigns made by the independent simulator, outside the repository."""
    beside = Path(__file__).resolve().parents[2] / "shared" / "campaign"
    folder = Path(os.environ.get("MECHID_CAMPAIGN", beside))
    if not (folder / "exact").is_dir():
        pytest.skip("no independent campaigns here; set MECHID_CAMPAIGN to the folder with exact/ and noisy/")
    return folder


@pytest.fixture(scope="session")
def update_golden(pytestconfig):
    """Return whether what is kept is to be made anew."""
    return pytestconfig.getoption(golden_text.OPTION)


@pytest.fixture(scope="session")
def data_folder():
    """Return the folder of measured data by others, outside the repository."""
    return measured_data.data_folder()


@pytest.fixture
def note(record_property):
    """Return a function that keeps a figure with the test's result, and prints it (see it with -s)."""

    def keep(text):
        record_property("figure", text)
        print(text)  # noqa: T201

    return keep


@pytest.fixture
def figure(pytestconfig):
    """Return a function that notes a number reached on measured data, and asserts that it is in its range."""

    def note(what, reached, *, least=-float("inf"), most=float("inf"), unit=""):
        found = Figure(what, float(reached), float(least), float(most), unit)
        pytestconfig.stash.setdefault(FIGURES, []).append(found)
        assert found.is_met, str(found)

    return note


def pytest_runtest_setup(item):
    """Skip the tests on measured data where there are none, all with one line."""
    if item.get_closest_marker("data"):
        measured_data.data_folder()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item):
    """Make a failure of a test on measured data that is skipped although the data are named."""
    report = yield
    if report.skipped and not hasattr(report, "wasxfail") and item.get_closest_marker("data") and os.environ.get(NAMED):
        report.outcome = "failed"
        report.longrepr = f"{item.nodeid}: skipped although {NAMED} is set: {report.longrepr}"
    return report


def pytest_terminal_summary(terminalreporter, config):
    """Print a line for each figure."""
    for figure in config.stash.get(FIGURES, []):
        terminalreporter.write_line(str(figure))
