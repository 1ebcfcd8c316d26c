"""Figures that are drawn beside what goes on. Truth: the same sheet drawn within this process; the files left."""

import os
import signal
from types import SimpleNamespace

import numpy as np
import pytest

from mechid.analysis import validate
from mechid.ink import pens as pens_module
from mechid.ink.pens import Pens
from mechid.ink.sheet import Sheet
from mechid.reports.illustration import Illustration

pytestmark = pytest.mark.usefixtures("processes_that_draw")
HZ = np.arange(1.0, 200.0)


def sheet(name="line", drawing="spectrum", **more):
    """Return a sheet of a spectrum with one line at 46 Hz, N m."""
    amplitudes = 1e-4 + np.where(HZ == 46.0, 0.5, 0.0)
    data = {
        "quantity": "torque",
        "hz": HZ,
        "amplitudes": (amplitudes,) * 3,
        "marks": [(46.0, "order 1")],
        "shown_hz": 200.0,
    }
    return Sheet(name, 2.4, drawing, data | more)


def test_a_process_draws_what_this_one_would(tmp_path, monkeypatch):
    """Truth: the same sheet drawn within this process, to the byte."""
    with Pens() as pens:
        pens.draw([sheet()], tmp_path)["line"].result()
    elsewhere = [(tmp_path / f"line.{kind}").read_bytes() for kind in ("svg", "png")]
    monkeypatch.setattr(pens_module, "_start_process", unable)
    with Pens() as none:
        none.draw([sheet()], tmp_path)["line"].result()
    assert [(tmp_path / f"line.{kind}").read_bytes() for kind in ("svg", "png")] == elsewhere
    assert b"order 1" in elsewhere[0]


def unable():
    """Refuse to start a process."""
    raise OSError


def test_what_cannot_be_drawn_is_raised_where_it_is_asked_for(tmp_path):
    """And the process goes on with the next sheet."""
    with Pens() as pens:
        wrong = pens.draw([sheet("wrong", "no such drawing")], tmp_path)["wrong"]
        with pytest.raises(KeyError, match="no such drawing"):
            wrong.result()
        pens.draw([sheet()], tmp_path)["line"].result()
    assert (tmp_path / "line.svg").is_file()


def test_a_process_that_ends_is_said(tmp_path):
    with Pens() as pens:
        for process in pens._processes:
            os.kill(process.pid, signal.SIGKILL)
        with pytest.raises(RuntimeError, match="ended with code -9"):
            pens.draw([sheet()], tmp_path)["line"].result()


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such signals to send to another process")
def test_signals_that_end_a_command_end_no_process_that_draws(tmp_path):
    """As a batch system sends them, to each process of a job: who waits for the figures decides."""
    with Pens() as pens:
        pens.draw([sheet()], tmp_path)["line"].result()
        for process in pens._processes:
            assert os.getpgid(process.pid) != os.getpgid(0)
            for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
                process.send_signal(number)
        pens.draw([sheet("again")], tmp_path)["again"].result()
    assert (tmp_path / "again.svg").is_file()


@pytest.mark.parametrize("was_there", [False, True])
def test_a_report_that_fails_leaves_no_folder_of_figures(reported, tmp_path, was_there):
    """One that was there before stays, with what is in it."""
    folder = tmp_path / "figures"
    if was_there:
        folder.mkdir()
        (folder / "earlier.svg").write_text("<svg/>")

    def fail():
        with Pens() as pens, Illustration(reported.campaign, reported.fit, tmp_path, pens) as illustration:
            illustration.begin(next(iter(reported.validation.values())))
            raise RuntimeError("no page")

    with pytest.raises(RuntimeError, match="no page"):
        fail()
    assert [path.name for path in tmp_path.iterdir()] == ["figures"] * was_there
    assert not was_there or (folder / "earlier.svg").is_file()


def test_figures_are_begun_before_validation_ends(reported, tmp_path):
    """The first record's are asked for before the second is validated; all that a report has come out of it."""
    asked = []

    class Asking(Pens):
        def draw(self, sheets, folder):
            found = super().draw(sheets, folder)
            asked.append(sorted(found))
            return found

    with Asking() as pens:
        illustration = Illustration(reported.campaign, reported.fit, tmp_path, pens)
        seen = []

        def begin(record, predictions):
            seen.append((record.name, len(asked)))
            illustration.begin(record, predictions)

        validate(reported.campaign, reported.fit, begin)
        nothing = {"correlation": {"names": []}, "information": None}
        curves, pictures = illustration.finish(nothing)
    assert seen == [("full_46", 0), ("sweep", 1)]
    assert [one.name for one in curves] == ["full_46", "sweep"]
    figures = {path.stem: path.read_text() for path in (reported.folder / "figures").glob("*.svg")}
    matrices = {"correlation", "information"}
    drawn = {name: path.read_text() for name, path in pictures.items()}
    assert drawn == {name: text for name, text in figures.items() if name not in matrices}


def test_what_fails_waits_until_the_figures_are_asked_for(reported, tmp_path):
    """Truth: the rule that an estimate is written before anything of its report can stop it."""
    stranger = SimpleNamespace(name="nobody's", channels={"torque": None})
    with Pens() as pens:
        illustration = Illustration(reported.campaign, reported.fit, tmp_path, pens)
        illustration.begin(stranger)
        illustration.begin(reported.validation["full_46"])
        with pytest.raises(Exception, match="nobody's"):
            illustration.finish({})
    assert not list((tmp_path / "figures").iterdir())
