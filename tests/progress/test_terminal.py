"""Truth: what was told, and the promise of one line at each stage change or every few seconds."""

import io
import json

from rich.console import Console

from mechid.identification.computation.journal import Journal
from mechid.identification.computation.progress import Progress
from mechid.identification.result.journal_file import StageLines
from mechid.progress.listening import progress_words
from mechid.progress.terminal import ProgressLine

REPORTS = [
    Progress(1, 4, "multi-start", "256 of 2048 starts", None, 0.5),
    Progress(1, 4, "multi-start", "512 of 2048 starts", None, 0.6),
    Progress(1, 4, "multi-start", "16 refined", 7100.706, 0.7),
    Progress(2, 4, "gated growth", "", None, 0.8),
]


def shown(reports, *, terminal):
    stream = io.StringIO()
    console = Console(file=stream, force_terminal=terminal, width=100, legacy_windows=False, _environ={})
    with ProgressLine(console) as line:
        for report in reports:
            line.tell(report)
    return stream.getvalue()


def test_a_report_in_words():
    assert progress_words(REPORTS[2]) == "stage 1 of 4: multi-start, 16 refined, cost 7100.71, 0.7 s"


def test_a_log_gets_the_first_and_the_last_line_of_each_stage():
    assert shown(REPORTS, terminal=False).splitlines() == [
        progress_words(REPORTS[0]),
        progress_words(REPORTS[2]),
        progress_words(REPORTS[3]),
    ]


def test_a_log_gets_a_line_every_few_seconds(monkeypatch):
    monkeypatch.setattr("mechid.progress.terminal.EVERY_S", 0.0)
    assert shown(REPORTS, terminal=False).splitlines() == [progress_words(report) for report in REPORTS]


def test_a_terminal_keeps_the_last_line_of_each_stage():
    text = shown(REPORTS, terminal=True)
    assert progress_words(REPORTS[2]) in text
    assert progress_words(REPORTS[3]) in text
    assert progress_words(REPORTS[0]) + "\n" not in text.replace("\r", "")


def test_nothing_told_is_nothing_shown():
    assert shown([], terminal=False) == ""


def test_the_journal_notes_a_stage_when_it_ends_and_keeps_earlier_runs(tmp_path):
    path = tmp_path / "journal.jsonl"
    for _ in range(2):
        stages = StageLines(Journal.open(path, {}, campaign="campaign.toml", seed=7))
        for report in REPORTS:
            stages.tell(report)
        noted = path.read_text().splitlines()  # while it still runs
    assert [json.loads(line)["event"] for line in noted] == ["started", "progress", "stage"] * 2  # all in one second
    assert json.loads(noted[-1]) | {"time": "", "check": ""} == {
        "time": "",
        "check": "",
        "event": "stage",
        "number": 1,
        "total": 4,
        "stage": "multi-start",
        "line": "16 refined",
        "cost": 7100.706,
        "elapsed_s": 0.7,
    }
