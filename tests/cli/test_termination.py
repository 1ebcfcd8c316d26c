"""Every command ends within two seconds of a signal, with 130 and a line. Truth: the system's count of CPU time."""

import json
import logging
import shutil
import signal
import subprocess
import sys

import numpy as np
import pytest

from mechid.budgets.example import BUDGET, STRUCTURE
from mechid.locks import LOCK_NAME
from signalled import Command

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")
PROMISED_S, MARGIN_S = 2.0, 0.5
LONG_S = 40.0
"""Of the clock: a command that waits ends 5 s after the signal, and the machine may be busy."""
# Ten thousand seconds of motion in steps of 125 ns before the first sample: one call of the kernel takes an hour.
FAR = """
mechanism = "mechanism.toml"
[[record]]
name = "far"
file = "far.csv"
sample_rate_hz = 8e6
time_offset_s = -10000.0
command = { stepping = "full", rate = 46.0 }
"""
PLANNED = """
mechanism = "mechanism.toml"
[[record]]
name = "planned"
command = { stepping = "full", rate = 46.0 }
"""
DESIGN = """
[recording]
noise_Nm = 0.002
[candidates]
steppings = ["full"]
rates = [23.0, 46.0]
"""


@pytest.fixture(scope="module")
def place(bench, fitted, tmp_path_factory):
    """Return a folder with all that the commands need; not to be changed."""
    folder = tmp_path_factory.mktemp("signals")
    for name in ("bench", "far", "plan", "planned"):
        shutil.copytree(bench, folder / name)
    shutil.copytree(fitted / "fit", folder / "fit")
    swing = np.sin(2.0 * np.pi * 46.0 * np.arange(2000) / 1e4)
    (folder / "far" / "far.csv").write_text("\n".join(["torque_Nm", *map(str, swing)]))
    (folder / "far" / "campaign.toml").write_text(FAR)
    (folder / "planned" / "campaign.toml").write_text(PLANNED)
    long = np.random.default_rng(1).normal(size=1_000_000)
    (folder / "long.csv").write_text("\n".join(["torque_Nm", *map(str, long)]))
    (folder / "plan" / "design.toml").write_text(DESIGN)
    (folder / "fit" / "budget.toml").write_text(BUDGET)
    (folder / "fit" / "structure.toml").write_text(STRUCTURE)
    return folder


COMMANDS = {
    "check": "check bench",
    "look": "look bench/sweep.csv --out {out}",
    "simulate": "simulate bench --out {out}",
    "identify": "identify bench --out {out}",
    "report": "report {fit}",
    "explore": "explore bench --no-browser",
    "compare": "compare fit fit",
    "profile": "profile fit --parameter housing.gain --out {out}",
    "bootstrap": "bootstrap fit --out {out}",
    "budget": "budget fit/budget.toml --out {out}",
    "design": "design plan --out {out}",
    "diagnose": "diagnose fit --out {out}",
    "export_c": "export fit --to c --out {out}",
    "export_fmu": "export fit --to fmu --out {out}",
    "export_linear": "export fit --to linear --out {out}",
    "export_tables": "export fit --to tables --out {out}",
    "fleet": "fleet bench --out {out}",
    "kernel": "kernel",
    "new": "new {out}/new",
    "demo": "demo --out {out}",
}
"""A command line each, in the folder of `place`."""
AT_WORK = {
    "check": ("check far", "kernel loaded", 4.0),
    "look": ("look long.csv --sample-rate-hz 10000 --out {out}", "", 1.5),
    "simulate": ("simulate planned --duration-s 15000 --out {out}", "kernel loaded", 2.0),
    "identify": ("identify bench --out {out}", "stage 1 of", 0.0),
    "report": ("report {fit}", "kernel loaded", 0.0),
    "profile": ("profile fit --parameter housing.gain --out {out}", "stage 1 of", 0.0),
    "bootstrap": ("bootstrap fit --draws 100000 --out {out}", "", 2.5),
    "budget": ("budget fit/budget.toml --out {out}", "", 2.0),
    "design": ("design plan --out {out}", "", 2.0),
    "fleet": ("fleet bench --out {out}", "stage 1 of", 0.0),
    "demo": ("demo --out {out}", "stage 1 of", 0.0),
}
"""Commands in the middle of their work: what they have said then, and the least of CPU seconds that they have taken."""


def begun(line, place, tmp_path, monkeypatch, **options):
    """Return a command that has begun, and its output folder."""
    monkeypatch.chdir(place)
    out, fit = tmp_path / "out", tmp_path / "fit"
    if "{fit}" in line:
        shutil.copytree(place / "fit", fit)
    return Command(line.format(out=out, fit=fit).split(), **options), out


def assert_ended(ending, out, line):
    """Assert what is promised of the end of a command."""
    logging.info("ended after %.2f s of CPU, %.2f s", ending.cpu_s, ending.wall_s)
    assert ending.code == 130, (ending.code, ending.stderr)
    assert ending.cpu_s <= PROMISED_S + MARGIN_S
    assert ending.wall_s <= LONG_S
    assert [said for said in ending.stderr.splitlines() if said.startswith("mechid: ")][-1].startswith(line)
    assert ending.stderr.count("mechid: ") == 1
    for odd in ("Traceback", "Exception ignored", "LLVM", "unexpected error", "RuntimeError"):
        assert odd not in ending.stderr + ending.stdout
    left = [path for path in out.rglob("*") if path.name == LOCK_NAME or path.name.endswith(".part")]
    assert left == []


@pytest.mark.parametrize("group", [False, True], ids=["parent", "group"])
@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_that_has_just_begun_ends_at_once(name, group, place, tmp_path, monkeypatch):
    number = (signal.SIGTERM, signal.SIGINT)[list(COMMANDS).index(name) % 2]
    command, out = begun(COMMANDS[name], place, tmp_path, monkeypatch)
    try:
        command.until(command.listens)
        assert_ended(command.end(number, group=group), out, "mechid: interrupted")
    finally:
        command.close()


LONG = ("report", "profile", "simulate", "demo", "design", "fleet", "bootstrap", "budget")


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow) if name in LONG else name for name in AT_WORK]
)
def test_a_command_at_work_ends_in_time(name, place, tmp_path, monkeypatch):
    line, marker, least_s = AT_WORK[name]
    command, out = begun(line, place, tmp_path, monkeypatch)
    try:
        command.until(lambda: marker in command.said() and command.cpu_s() >= least_s)
        assert_ended(command.end(signal.SIGTERM), out, "mechid: interrupted")
    finally:
        command.close()


def test_a_second_signal_ends_it_at_once(place, tmp_path, monkeypatch):
    """Truth: the first one leaves the kernel's call 1.5 s; half a second later comes the second."""
    command, out = begun(AT_WORK["check"][0], place, tmp_path, monkeypatch)
    try:
        command.until(lambda: "kernel loaded" in command.said() and command.cpu_s() >= 4.0)
        ending = command.end(signal.SIGINT, signal.SIGTERM, pause_s=0.5)
        assert_ended(ending, out, "mechid: interrupted")
        assert ending.cpu_s < 1.2
    finally:
        command.close()


def test_signals_close_together_are_one(place, tmp_path, monkeypatch):
    """As `timeout` sends them, to the process and its group. Truth: a second signal leaves no time to keep values."""
    command, out = begun(AT_WORK["identify"][0], place, tmp_path, monkeypatch)
    try:
        command.until(lambda: "stage 1 of" in command.said())
        assert_ended(command.end(signal.SIGTERM, signal.SIGTERM, pause_s=0.0), out, "mechid: interrupted; ")
        assert json.loads((out / "estimate.json").read_text())["outcome"]["code"] == "interrupted"
    finally:
        command.close()


@pytest.mark.parametrize("count", [pytest.param(1, marks=pytest.mark.slow), 2], ids=["once", "twice"])
def test_a_compilation_ends_without_a_word_of_the_compiler(count, place, tmp_path, monkeypatch):
    """LLVM aborts where Python ends beneath a thread that compiles."""
    environment = {"MECHID_CACHE": str(tmp_path / "cache")}
    command, out = begun("check bench", place, tmp_path, monkeypatch, environment=environment)
    try:
        command.until(lambda: "compiling the kernel" in command.said() and command.cpu_s() >= 3.0)
        assert_ended(command.end(*[signal.SIGTERM] * count), out, "mechid: interrupted")
    finally:
        command.close()


@pytest.mark.parametrize(("interrupted", "code"), [(True, 130), (False, 1)])
def test_an_error_that_a_signal_has_caused_is_an_interruption(interrupted, code):
    """Truth: Python's RuntimeError where a signal falls into the making of a class; without a signal it is a fault."""
    text = (
        "from mechid.cli import app, termination, main\n"
        "def fail():\n"
        f"    termination._SHUTDOWN.is_raised = {interrupted}\n"
        "    raise RuntimeError('Error calling __set_name__')\n"
        "app.main = fail\n"
        "main()\n"
    )
    ended = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=False)
    assert ended.returncode == code, ended.stderr
    assert ("Traceback" in ended.stderr) is not interrupted


LOST = """
import os, signal, sys, time, weakref
from mechid.cli import termination
class Collected:
    pass
def signal_this_process(reference):
    os.kill(os.getpid(), signal.SIGTERM)
    for _ in range(1000):
        pass
collected = Collected()
reference = weakref.ref(collected, signal_this_process)
def lose_signal():
    global collected
    collected = None
install = signal.signal
def install_and_lose(number, handler):
    install(number, handler)
    if number == signal.SIGTERM:
        lose_signal()
install(signal.SIGINT, signal.SIG_IGN)
began = time.monotonic()
try:
    if sys.argv[1] == "set-up":
        signal.signal = install_and_lose
    termination.listen_for_signals()
    lose_signal()
    while time.monotonic() - began < 60.0:
        pass
except KeyboardInterrupt:
    termination.say_interrupted()
    print("results saved")
    termination.end(130)
"""
"""SIGTERM in the callback of a weak reference, in which Python ignores exceptions; SIGINT is ignored as in a script."""


@pytest.mark.parametrize("when", ["set-up", "work"])
def test_an_interruption_that_python_ignored_is_raised_again(when):
    """Truth: Python ignores any exception of such a callback; results are saved only where the main thread has one."""
    ended = subprocess.run([sys.executable, "-c", LOST, when], capture_output=True, text=True, check=False)
    assert ended.returncode == 130
    assert ended.stderr == "mechid: interrupted\n"
    assert ended.stdout == "results saved\n"
