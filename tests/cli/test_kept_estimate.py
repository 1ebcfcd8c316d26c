"""What a search has found stays, whatever ends the command after it. Truth: a run that nothing disturbed."""

import json
import shutil
import signal
import sys
from contextlib import nullcontext

import pytest
from typer.testing import CliRunner

import mechid
from mechid.campaign import load_campaign
from mechid.cli.app import app
from mechid.identification import conclude
from mechid.identification.diagnosis import diagnosis, start
from mechid.identification.result.fit_file import read_fit
from mechid.identification.result.grade import UNEXAMINED
from mechid.reports import into_folder
from signalled import Command

RESULTS = ["estimate.json", "journal.jsonl", "mechanism.toml", "report.json"]
ASKING, DRAWING = "asking the residual", "making the report"


def numbers(folder):
    """Return estimate.json without what differs from run to run, and its warnings."""
    content = json.loads((folder / "estimate.json").read_text())
    content["provenance"].pop("wall_time_s")
    for stage in content["stages"]:
        stage.pop("seconds")
    return content, content["warnings"]


@pytest.fixture(scope="module")
def wrong(fitted, tmp_path_factory):
    """Return the folder of a campaign whose fit asks for missing effects, and that of its undisturbed results."""
    folder = tmp_path_factory.mktemp("wrong")
    shutil.copytree(fitted / "bench", folder / "bench")
    mechanism = folder / "bench" / "mechanism.toml"
    text = mechanism.read_text()
    assert text.count("viscous = 0.0061") == 1
    mechanism.write_text(text.replace("viscous = 0.0061", "viscous = 0.0075"))
    CliRunner().invoke(app, ["identify", str(folder / "bench"), "--out", str(folder / "whole")])
    return folder


def disturbed(monkeypatch, module, name, error):
    def fail(*arguments, **options):
        raise error

    monkeypatch.setattr(module, name, fail)


@pytest.mark.parametrize(
    ("name", "error"),
    [
        pytest.param("validate", OSError(5, "Input/output error"), marks=pytest.mark.slow),
        ("add_suggestions", KeyboardInterrupt()),
        pytest.param("validate", KeyboardInterrupt(), marks=pytest.mark.slow),
        pytest.param("add_suggestions", MemoryError(), marks=pytest.mark.slow),
    ],
)
@pytest.mark.usefixtures("without_reports")
def test_what_ends_the_examination_leaves_the_estimate(run, wrong, tmp_path, monkeypatch, name, error):
    out = tmp_path / "out"
    with monkeypatch.context() as patched:
        disturbed(patched, into_folder if name == "validate" else start, name, error)
        result = run("identify", wrong / "bench", "--out", out)
    assert result.exit_code == (130 if isinstance(error, KeyboardInterrupt) else result.exit_code) != 0
    assert sorted(path.name for path in out.iterdir()) == RESULTS
    content, warnings = numbers(out)
    whole, said = numbers(wrong / "whole")
    assert warnings == [*said, UNEXAMINED]
    assert (content["grade"], content["outcome"], content["parameters"]) == (
        whole["grade"],
        whole["outcome"],
        whole["parameters"],
    )
    if isinstance(error, KeyboardInterrupt):
        assert f"the estimate is in {out}, not examined any further" in result.stderr
    assert read_fit(out / "estimate.json", load_campaign(wrong / "bench")).warnings[-1] == UNEXAMINED
    run("identify", wrong / "bench", "--out", out, "--resume")
    assert numbers(out) == numbers(wrong / "whole")


def test_a_diagnosis_that_is_interrupted_leaves_the_estimate(run, wrong, tmp_path, monkeypatch):
    disturbed(monkeypatch, diagnosis, "diagnose", KeyboardInterrupt())
    result = run("identify", wrong / "bench", "--complete", "--out", tmp_path / "out")
    assert result.exit_code == 130
    assert numbers(tmp_path / "out")[1][-1] == UNEXAMINED
    assert numbers(tmp_path / "out")[0]["parameters"] == numbers(wrong / "whole")[0]["parameters"]


def test_from_python_an_interrupted_examination_leaves_the_fit(wrong, monkeypatch):
    disturbed(monkeypatch, start, "add_suggestions", KeyboardInterrupt())
    fit = mechid.identify(load_campaign(wrong / "bench"))
    assert fit.warnings[-1] == UNEXAMINED
    whole, _ = numbers(wrong / "whole")
    assert str(fit.grade) == whole["grade"]


def test_a_search_keeps_what_it_has_before_its_last_steps(run, wrong, tmp_path, monkeypatch):
    """Truth: the values of the whole run, whose errors are worked out after what is kept here."""

    class Ended(BaseException):
        pass

    real = conclude.standard_errors

    def end(state, *rest, **options):
        if state.searched:
            raise Ended
        return real(state, *rest, **options)

    monkeypatch.setattr(conclude, "standard_errors", end)
    with pytest.raises(Ended):
        into_folder.identify_into_folder(load_campaign(wrong / "bench"), tmp_path, quiet())
    content, _ = numbers(tmp_path)
    whole, _ = numbers(wrong / "whole")
    assert (content["grade"], content["outcome"]["code"]) == ("failed", "interrupted")
    for name, p in whole["parameters"].items():
        assert content["parameters"][name]["value"] == pytest.approx(p["value"], rel=1e-12)


def quiet():
    return into_folder.Audience(followed=lambda: nullcontext(lambda progress: None), say=lambda line: None)


@pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")
@pytest.mark.parametrize(
    ("marker", "group", "count"),
    [
        pytest.param(ASKING, False, 1, marks=pytest.mark.slow),
        pytest.param(DRAWING, False, 2, marks=pytest.mark.slow),
        pytest.param(DRAWING, True, 1, marks=pytest.mark.slow),
        pytest.param(ASKING, True, 1, marks=pytest.mark.slow),
        pytest.param(ASKING, False, 2, marks=pytest.mark.slow),
        pytest.param(DRAWING, False, 1, marks=pytest.mark.slow),
        pytest.param(DRAWING, True, 2, marks=pytest.mark.slow),
    ],
)
def test_a_signal_after_the_search_keeps_the_estimate(wrong, tmp_path, marker, group, count):
    out = tmp_path / "out"
    command = Command(["identify", wrong / "bench", "--out", out])
    try:
        command.until(lambda: marker in command.said())
        ending = command.end(*[signal.SIGTERM] * count, group=group)
    finally:
        command.close()
    assert ending.code == 130, ending.stderr
    assert ending.cpu_s <= 2.5
    assert "mechid: interrupted" in ending.stderr
    for odd in ("Traceback", "RuntimeError", "ended with code", "LLVM", "Exception ignored"):
        assert odd not in ending.stderr
    content, warnings = numbers(out)
    assert content["grade"] == numbers(wrong / "whole")[0]["grade"]
    assert (UNEXAMINED in warnings) == (marker == ASKING)
    assert not [path for path in out.rglob("*") if path.name.endswith((".part", ".lock"))]
