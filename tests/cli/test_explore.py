"""`mechid explore`. Truth: what identify leaves, what HTTP answers, the documented exit codes."""

import os
import signal
import socket
import subprocess
import sys
import threading
import urllib.request
from dataclasses import replace

import pytest

import synthetic
from diagnosis_folder import DETENT, left, missing
from mechid.campaign import load_campaign
from mechid.identification.result import journal_file
from mechid.identification.result.estimate_file import read_estimate
from mechid.identification.result.settings import GRADE
from mechid.web import Source, read_estimated
from mechid.web.session import Session

WAIT_S = 120.0


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGINT to send to another process")
def test_it_prints_where_the_page_is_and_ctrl_c_ends_it(staged):
    process = subprocess.Popen(
        [sys.executable, "-m", "mechid", "explore", str(staged), "--no-browser"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONUNBUFFERED": "1"},
    )
    watchdog = threading.Timer(WAIT_S, process.kill)
    watchdog.start()
    try:
        address = process.stdout.readline().split()[0]
        with urllib.request.urlopen(address, timeout=WAIT_S) as answer:
            page = answer.read().decode()
        process.send_signal(signal.SIGINT)
        _, said = process.communicate()
    finally:
        watchdog.cancel()
        process.kill()
    assert address.startswith("http://127.0.0.1:")
    assert f"<h1>{staged.name}</h1>" in page
    assert "<b>Synthetic.</b>" in page
    assert "Traceback" not in said
    assert process.returncode == 0, said


def test_a_tab_follows_an_identification_elsewhere_and_takes_up_its_estimate(run, staged, tmp_path, monkeypatch):
    monkeypatch.setattr(journal_file, "GRADE", replace(GRADE, progress_interval_s=0.0))
    out = tmp_path / "result"
    session = Session(Source(load_campaign(staged), journal=out / journal_file.FILE_NAME))
    notes = []

    class Noted(journal_file.StageLines):
        """Looks at the tab each time that something is noted."""

        def tell(self, progress):
            super().tell(progress)
            session.follow()
            notes.append((session.shown_run.state.value, len(session.shown_run.reports)))

    monkeypatch.setattr("mechid.reports.into_folder.StageLines", Noted)
    assert run("identify", staged, "--out", out).exit_code == 0
    assert notes == [("running", k) for k in range(1, len(notes) + 1)]
    assert len(notes) > 3
    session.follow()
    assert session.reading.wait(WAIT_S)
    assert session.adopt_result()
    parameters = read_estimate(out / "estimate.json")["parameters"]
    assert session.state.now.values["gear.stiffness"] == parameters["gear.stiffness"]["value"]
    assert not session.adopt_result()
    assert read_estimated(out / "estimate.json", session.source.campaign).values == session.estimate.values


def test_what_is_wrong_is_said_before_anything_is_served(refused, changed, staged, tmp_path):
    assert "there is no such file" in refused(3, "explore", staged, "--no-browser", "--fit", tmp_path / "nowhere")
    assert "stiffnes" in refused(3, "explore", changed("mechanism.toml", "stiffness =", "stiffnes ="), "--no-browser")


def test_a_diagnosis_that_is_not_there_or_of_another_file_is_said(refused, staged, tmp_path):
    assert '"mechid diagnose" writes it' in refused(3, "explore", staged, "--no-browser", "--diagnosis", tmp_path)
    proposed = synthetic.truth().with_values({"gear.ratio": 51.0})
    left(tmp_path, proposed, missing("stepper.detent:3.6deg", dict.fromkeys(DETENT, 0.01), "stepper.detent"))
    line = refused(3, "explore", staged, "--no-browser", "--diagnosis", tmp_path)
    assert "mechanism_proposed.toml: is not of" in line


def test_a_port_that_is_taken_is_said(refused, staged):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        line = refused(2, "explore", staged, "--no-browser", "--port", taken.getsockname()[1])
    assert "port" in line
