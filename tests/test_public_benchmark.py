"""Public benchmark: its scores, its refusal of wrong submissions, and that no answer lies beside a task."""

import copy
import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from public.maker import sheets
from public.maker.campaigns import TABLE, resonance_of, sizes_of, truth_of
from public.maker.measurement import NOISE_NM, NOISES, measured
from public.maker.runs import held_out_of, runs_of
from public.mechid_benchmark import __main__ as command_line
from public.mechid_benchmark.answers import read_answers
from public.mechid_benchmark.emission import RATE_HZ, emission_of
from public.mechid_benchmark.scores import score_submission
from public.mechid_benchmark.submission import read_submission
from public.mechid_benchmark.tasks import CAMPAIGNS, FORMAT, ORDERS, UNITS

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "benchmarks" / "public"
WRONG_SUBMISSION = 3


def perfect(*campaigns):
    """Return a submission of the true values, intervals of 1 % about them."""
    entries = {}
    for number in campaigns:
        answer = read_answers()[number]
        parameters = {
            name: {"value": true, "interval": [true - 0.01 * abs(true), true + 0.01 * abs(true)]}
            for name, true in answer["parameters"].items()
        }
        entries[number] = {"parameters": parameters, "emission": answer["emission"], "cpu_s": 2.0}
    return {"format": FORMAT, "name": "perfect", "campaigns": entries}


def scored(told, folder):
    file = folder / "submission.json"
    file.write_text(json.dumps(told))
    return score_submission(read_submission(file), read_answers())


def test_the_truth_scores_no_error_and_its_intervals_hold(tmp_path):
    """Truth: the answers themselves, of two of ten campaigns."""
    score = scored(perfect("01", "06"), tmp_path)
    whole = score["all"]
    assert set(score["campaigns"]) == {"01", "06"}
    assert (whole["asked"], whole["given"], whole["stated"], whole["held"]) == (150, 30, 30, 30)
    assert whole["worst_percent"] == whole["worst_emission_percent"] == whole["rms_percent"] == 0.0
    assert (whole["runs"], whole["cpu_s"]) == (6, 4.0)


def test_errors_are_those_by_hand(tmp_path):
    """Truth: a stiffness 3 % off, a phase 2 degrees off across the cut at 180, one line off by the length of all."""
    told = perfect("01")
    entry, answer = told["campaigns"]["01"], read_answers()["01"]
    stiffness, phase = entry["parameters"]["gear.stiffness"], entry["parameters"]["stepper.detent.0.phase_deg"]
    stiffness |= {"value": 1.03 * stiffness["value"], "interval": None}
    turned = phase["value"] + 2.0 - 360.0
    phase |= {"value": turned, "interval": [turned - 1.0, turned + 1.0]}
    lines = answer["emission"]["half_low"]["lines_Nm"]
    entry["emission"] = copy.deepcopy(answer["emission"])
    entry["emission"]["half_low"]["lines_Nm"][0] += float(np.linalg.norm(lines))
    entry["emission"]["half_low"]["rms_Nm"] *= 1.5
    score = scored(told, tmp_path)["campaigns"]["01"]
    assert score["worst"] == "stepper.detent.0.phase_deg"
    assert score["worst_percent"] == pytest.approx(100.0 * np.radians(2.0))
    assert (score["stated"], score["held"]) == (14, 13)
    assert score["width_percent"] == pytest.approx(1.0)
    assert score["worst_emission_percent"] == pytest.approx(100.0)
    assert score["emission_percent"] == 0.0
    assert score["rms_percent"] == pytest.approx(50.0)


def test_an_interval_of_an_angle_holds_across_the_cut(tmp_path):
    """Truth: the circle."""
    told = perfect("01")
    phase = told["campaigns"]["01"]["parameters"]["stepper.detent.0.phase_deg"]
    phase |= {"value": phase["value"] - 360.0, "interval": [phase["value"] - 361.0, phase["value"] - 359.0]}
    assert scored(told, tmp_path)["all"]["held"] == 15


def change(told, path, value):
    """Set the value at a path of keys; None removes it."""
    *way, last = path
    for key in way:
        told = told[key]
    if value is None:
        del told[last]
    else:
        told[last] = value


CAMPAIGN = ("campaigns", "01")
STIFFNESS = (*CAMPAIGN, "parameters", "gear.stiffness")


@pytest.mark.parametrize(
    ("path", "value", "says"),
    [
        (("format",), "mechid-benchmark-submission/2", "this version reads"),
        (("name",), None, 'lacks the key "name"'),
        (("name",), " ", "name the method"),
        (("campaigns",), {}, "enter at least one campaign"),
        (("campaigns", "11"), {"parameters": {}}, 'unknown key "11"'),
        (CAMPAIGN, [], "campaigns.01: is not an object"),
        ((*CAMPAIGN, "parameters"), None, 'lacks the key "parameters"'),
        ((*CAMPAIGN, "parameters", "gear.stifness"), {"value": 1.0}, 'did you mean "gear.stiffness"?'),
        (STIFFNESS, 1500.0, "gear.stiffness: is not an object"),
        ((*STIFFNESS, "value"), "1500", '"1500" is not a number'),
        ((*STIFFNESS, "value"), True, "true is not a number"),
        ((*STIFFNESS, "value"), float("nan"), "NaN is no number of JSON"),
        ((*STIFFNESS, "value"), 10**400, "is not a finite number"),
        ((*STIFFNESS, "interval"), [1.0], "write [low, high]"),
        ((*STIFFNESS, "interval"), [1.0, 2.0], "does not hold the value"),
        ((*CAMPAIGN, "emission", "half_low", "lines_Nm"), [0.1], "is not a list of 6 numbers"),
        ((*CAMPAIGN, "emission", "half_low", "rms_Nm"), -0.1, "of at least 0"),
        ((*CAMPAIGN, "cpu_s"), -1.0, "of at least 0"),
    ],
)
def test_a_wrong_submission_is_one_line_and_exit_code_3(path, value, says, tmp_path, capsys):
    """Truth: the fault that was put in."""
    told = perfect("01")
    change(told, path, value)
    file = tmp_path / "submission.json"
    file.write_text(json.dumps(told))
    assert refusal(file, capsys) == Refusal(file, says)


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"{", "is no valid JSON"),
        (b"\xff\xfe", "it is not UTF-8 text"),
        (b"[" * 100_000, "is no valid JSON"),
        (b'{"name": "a", "name": "b"}', "stands twice"),
        (b"[]", "the file: is not an object"),
    ],
)
def test_a_file_that_is_no_submission_is_refused(content, says, tmp_path, capsys):
    """Truth: the file's bytes."""
    file = tmp_path / "submission.json"
    file.write_bytes(content)
    assert refusal(file, capsys) == Refusal(file, says)


def test_a_missing_file_is_refused(tmp_path, capsys):
    """Truth: there is no such file."""
    assert refusal(tmp_path / "none.json", capsys) == Refusal(tmp_path / "none.json", "cannot be read")


def refusal(file, capsys):
    code = command_line.main(["score", str(file)])
    out, said = capsys.readouterr()
    return code, out, said


class Refusal:
    """Equal to a refusal: exit code 3, nothing printed, one line that begins with the file and says so."""

    def __init__(self, file, words):
        self.file, self.words = file, words

    def __eq__(self, found):
        code, out, said = found
        one_line = said.count("\n") == 1 and said.startswith(f"{self.file}: ")
        return (code, out) == (WRONG_SUBMISSION, "") and one_line and self.words in said

    def __repr__(self):
        return f"exit 3, one line with {self.words!r}"

    __hash__ = None


def test_the_package_scores_without_mechid(tmp_path):
    """Truth: a process in which mechid cannot be imported."""
    file = tmp_path / "submission.json"
    file.write_text(json.dumps(perfect("03")))
    program = (
        "import sys, runpy; sys.modules['mechid'] = None; "
        f"sys.argv = ['mechid_benchmark', 'score', {str(file)!r}]; "
        "runpy.run_module('mechid_benchmark', run_name='__main__')"
    )
    done = subprocess.run([sys.executable, "-c", program], cwd=PACKAGE, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "| 03 | 15 of 15 |" in done.stdout
    assert "| 01 | not entered |" in done.stdout


def test_the_generator_imports_nothing_of_mechid():
    """Truth: the sources of the generator and of the simulator below it."""
    below = [ROOT / "benchmarks" / "incomplete" / f"{name}.py" for name in ("plant", "stepping", "effects")]
    sources = [*(PACKAGE / "maker").glob("*.py"), *(PACKAGE / "mechid_benchmark").glob("*.py"), *below]
    assert len(sources) > 10
    imports = [line for path in sources for line in path.read_text(encoding="utf-8").splitlines() if "import" in line]
    assert not [line for line in imports if re.search(r"(from|import) mechid\b", line)]


@pytest.mark.parametrize("number", CAMPAIGNS)
def test_a_task_holds_no_answer(number):
    """Truth: the values that make the records, by their first four digits, and the kinds of the campaigns."""
    resonance_hz = resonance_of(number)
    task = sheets.task_of(number, runs_of(resonance_hz), held_out_of(resonance_hz))
    text = json.dumps(task) + sheets.sheet_of(task)
    told = {f"{float(found):.4g}" for found in re.findall(r"[\d.]*\d(?:e[+-]?\d+)?", text)}
    hidden = [*truth_of(number).values(), *(one for one in sizes_of(number).values() if one != round(one))]
    assert not told & {f"{abs(value):.4g}" for value in hidden}
    assert TABLE[number].kind not in text


@pytest.mark.parametrize("number", CAMPAIGNS)
def test_the_catalogue_bounds_hold_the_truth(number):
    """Truth: the drawn values; an answer outside of the bounds could not be found."""
    truth = truth_of(number)
    assert truth == read_answers()[number]["parameters"]
    assert set(truth) == set(UNITS) == set(sheets.CATALOGUE)
    assert all(low <= truth[name] <= high for name, (_, low, high) in sheets.CATALOGUE.items())


def test_the_lines_of_an_emission_are_the_amplitudes():
    """Truth: sines of known amplitudes on a constant; the RMS of a sum of sines is that of their squares."""
    rate, amplitudes = 48.7, [0.01, 0.3, 0.0, 0.05, 0.02, 0.004]
    t = np.arange(20_001) / RATE_HZ
    sines = [a * np.sin(2.0 * np.pi * rate * o * t + o) for a, o in zip(amplitudes, ORDERS, strict=True)]
    found = emission_of(0.7 + np.sum(sines, axis=0), rate)
    assert found["lines_Nm"] == pytest.approx(amplitudes, abs=1e-12)
    assert found["rms_Nm"] == pytest.approx(np.linalg.norm(amplitudes) / np.sqrt(2.0), rel=2e-2)


def test_an_emission_of_too_short_a_run_is_refused():
    """Truth: the window ends at 2 s."""
    with pytest.raises(ValueError, match="window ends at sample 20000"):
        emission_of(np.zeros(19_999), 48.7)


@pytest.mark.parametrize(("noise", "rms"), [("white", 1.0), ("resonant", np.sqrt(1.25)), ("bench", np.sqrt(1.23))])
def test_the_noise_is_as_large_as_it_says(noise, rms):
    """Truth: variances of independent parts add up: 1, 1 + 1/4, 1 + 0.3^2 + (1 + 1/9)/8."""
    series = NOISES[noise](np.random.default_rng(1), 200_000)
    assert np.std(series) == pytest.approx(rms * NOISE_NM, rel=0.02)


def test_a_loose_transducer_loses_gain_from_an_instant_on():
    """Truth: the first quarter of the record as it was, the last 0.5 to 0.7 of it, noise of 2 mN m."""
    y = measured(np.full(10_000, 5.0), np.random.default_rng(2), noise="white", loose=True)
    assert np.mean(y[:2500]) == pytest.approx(5.0, abs=0.05)
    assert 2.45 < np.mean(y[-2500:]) < 3.55


@pytest.mark.slow
def test_the_answers_are_those_of_the_generator():
    """Truth: the generator run anew."""
    stored, anew = read_answers(), sheets.answers()
    assert set(stored) == set(anew) == set(CAMPAIGNS)
    for number in CAMPAIGNS:
        assert stored[number]["parameters"] == anew[number]["parameters"]
        for run, one in anew[number]["emission"].items():
            assert stored[number]["emission"][run]["lines_Nm"] == pytest.approx(one["lines_Nm"], rel=1e-4, abs=1e-6)
            assert stored[number]["emission"][run]["rms_Nm"] == pytest.approx(one["rms_Nm"], rel=1e-5)


@pytest.mark.slow
def test_mechid_enters_the_complete_campaign(tmp_path):
    """Truth: the answers; made, identified from the catalogue and scored as the one command does it."""
    program = [sys.executable, ROOT / "benchmarks" / "public_benchmark.py", "table", "--out", tmp_path]
    program += ["--methods", "mechid", "--campaigns", "01"]
    done = subprocess.run([str(part) for part in program], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    score = scored(json.loads((tmp_path / "mechid.json").read_text()), tmp_path)["campaigns"]["01"]
    assert "| 01 | 15 of 15 |" in done.stdout
    assert score["worst_percent"] < 1.0
    assert score["worst_emission_percent"] < 1.0
    # Of 15 intervals that each hold with 95 %, fewer than 11 hold with a chance of 1 in 1600 if independent.
    assert score["held"] >= 11
    assert score["remark"].startswith("grade A")
