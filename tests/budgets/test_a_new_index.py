"""A new index as one row, walked through all that an index goes through; nothing else of mechid is told of it."""

import json

import numpy as np
import pytest

from mechid.budgets.budget import make_budget
from mechid.budgets.budget_file import read_budget_file
from mechid.budgets.example import BUDGET, write_example
from mechid.budgets.indices import KINDS, Index, Kind
from mechid.budgets.levels import level
from mechid.budgets.numbers import budget_numbers
from mechid.budgets.other_errors import OtherError
from mechid.budgets.pointing_error import PointingError, Source
from mechid.budgets.profile_run import ProfileResponse
from mechid.errors import InputFileError, UsageError
from mechid.identification.result.estimate_file import json_text
from mechid.identification.result.fit_file import read_fit
from paper_estimate import write_estimate_of_paper

ROW = Kind(
    name="SDE",
    words="second difference of three windows' means",
    form=lambda e: e.mean(2) - 2.0 * e.mean(1) + e.mean(),
    weight=lambda s, turn: 16.0 * np.sin(turn) ** 4 * s**2,
    weight_words=r"16 \sin^4(\pi f S) s^2",
    separations=2,
    needs_held_body=False,
)
T, S = 0.2, 0.5
ONE = np.array([True])


@pytest.fixture(autouse=True)
def row(monkeypatch):
    monkeypatch.setitem(KINDS, ROW.name, ROW)


@pytest.fixture
def index():
    return Index("SDE", T, S)


def gain(f):
    """Return |gain| of a line, written out: 4 sin^2(pi f S) |sinc(f T)|."""
    return 4.0 * np.sin(np.pi * f * S) ** 2 * abs(np.sinc(f * T))


@pytest.mark.parametrize("f", [0.3, 0.8, 3.7])
def test_its_level_of_a_line(index, f):
    """Truth: the arcsine quantile of the line times its gain; a bias does not count."""
    error = PointingError(np.array([5.0]), (Source("a", f, np.array([1]), np.array([[2.0j]])),))
    for confidence in (0.5, 0.95):
        expected = 2.0 * gain(f) * np.sin(0.5 * np.pi * confidence)
        assert level(error, index, confidence, 0) == pytest.approx(expected, rel=1e-5)


def test_its_level_of_a_profile(index):
    """Truth: a t^2 / 2 has the second difference a S^2 of any windows, whatever drift and bias there are besides."""
    rate, a = 100.0, 3.0
    t = np.arange(500) / rate
    series = (0.5 * a * t**2 - 4.0 * t + 7.0)[:, None]
    made = ProfileResponse(("x",), t, rate, series, np.zeros((0, *series.shape)), 1, 1.0)
    assert level(made.error_under(index)(np.zeros(0)), index, 0.9, 0) == pytest.approx(a * S**2, rel=1e-9)
    with pytest.raises(UsageError, match=r"SDE needs 5[.]2 s, the profile takes 5 s"):
        made.error_under(Index("SDE", 0.2, 2.5))


def test_its_share_of_other_sources_in_the_ecss_sum(index):
    """Truth: the gain at the wheel's frequency; of noise the mean of its square over the band; nothing of a bias."""
    wheel = OtherError(name="w", kind="periodic", axes=ONE, size_rad=2.0, frequency_hz=3.7)
    noise = OtherError(name="n", kind="random", axes=ONE, size_rad=2.0, bandwidth_hz=5.0)
    f = (np.arange(100_000) + 0.5) * 5e-5
    assert wheel.contribution(index, 0).size == pytest.approx(2.0 * gain(3.7))
    assert noise.contribution(index, 0).size == pytest.approx(2.0 * np.sqrt(np.mean(gain(f) ** 2)), rel=2e-3)
    assert OtherError(name="b", kind="bias", axes=ONE, size_rad=1.0).contribution(index, 0) is None


REQUIREMENT = """
[[requirement]]
name = "curvature"
index = "SDE"
window_s = 0.2
separation_s = 0.5
axis = "x"
limit_rad = 1e-5
interpretation = "temporal"
confidence = 0.95
evaluation_period_s = 600.0
"""


def budget_file(folder, requirement):
    """Return the example with the slew alone, on a free body, and one more requirement."""
    write_estimate_of_paper(folder)
    write_example(folder)
    start, slew, end = BUDGET.index("[[mode]]"), BUDGET.index('[[mode]]\nname = "slew"'), BUDGET.index("[[error]]")
    text = BUDGET[:start] + BUDGET[slew : BUDGET.index('[[mode]]\nname = "run up"')] + BUDGET[end:] + requirement
    (folder / "budget.toml").write_text(text.replace("attitude_control =", "# attitude_control ="), encoding="utf-8")
    return read_budget_file(folder / "budget.toml")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("window_s = 0.2\n", "", r"requirement\[2\].window_s: found 0; SDE needs window_s"),
        ("separation_s = 0.5\n", "", r"requirement\[2\].separation_s: found 0; SDE needs separation_s"),
        ("_period_s = 600.0", "_period_s = 1.1", "found 1.1; the windows take 1.2 s"),
        ('"SDE"', '"SDA"', 'found "SDA"; did you mean "SDE"'),
    ],
)
def test_what_it_needs_of_a_budget_file(tmp_path, old, new, said):
    with pytest.raises(InputFileError, match=said):
        budget_file(tmp_path, REQUIREMENT.replace(old, new))


@pytest.mark.slow
def test_it_is_in_the_budget_and_its_report(write_report, tmp_path):
    """Truth: a million draws of the phases of the slew's lines and the wheel's, each with its gain, and of the noise;
    the words of the row. A free body does it no harm."""
    asked = budget_file(tmp_path, REQUIREMENT)
    made = make_budget(asked, read_fit(asked.estimate))
    data = json.loads(json_text(budget_numbers(made)))
    (row,) = (r for r in data["requirements"] if (r["index"], r["mode"]) == ("SDE", "slew"))
    (response,) = made.modes[0].responses
    f, rng = response.state.frequency_hz, np.random.default_rng(6)
    kept = response.phasors[:, 0] * (np.exp(2j * np.pi * f * S) - 1.0) ** 2 * np.sinc(f * T)
    turn, other, noise = rng.uniform(size=1_000_000), rng.uniform(size=1_000_000), rng.normal(size=1_000_000)
    density = (np.arange(100_000) + 0.5) * 2e-5
    draws = 3e-8 * gain(33.0) * np.cos(2.0 * np.pi * other) + 4e-8 * np.sqrt(np.mean(gain(density) ** 2)) * noise
    for k, phasor in zip(response.state.orders, kept, strict=True):
        if abs(phasor) > 1e-3 * np.abs(kept).max():
            draws += (phasor * np.exp(2j * np.pi * k * turn)).real
    assert row["nominal_rad"] == pytest.approx(np.quantile(np.abs(draws), 0.95), rel=5e-3)
    assert (row["separation_s"], row["index_words"]) == (S, ROW.words)
    (told,) = (w for w in made.warnings if "rigid body is free" in w)
    assert "pointing asks" in told
    write_report(data, tmp_path)
    page = (tmp_path / "budget.html").read_text(encoding="utf-8")
    assert 'title="second difference of three windows&#39; means">SDE 0.2 s, 0.5 s apart, x' in page
    assert "SDE 0.2 s, 0.5 s apart" in (tmp_path / "budget.md").read_text(encoding="utf-8")
