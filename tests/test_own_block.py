"""The tutorial on blocks of one's own runs as it stands. Truth: its equations, typed by hand here."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from mechid.campaign import load_campaign, load_mechanism
from mechid.campaign.prediction import simulate
from mechid.cli.app import app
from mechid.errors import InputFileError
from mechid.kernel.equations import equations_of
from mechid.kernel.twin import simulate_twin

ROOT = Path(__file__).resolve().parents[1]
EXAMPLE, PAGE = ROOT / "examples" / "own_block", ROOT / "docs" / "own_block.md"
PYTHON = re.findall(r"^```python\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)


@pytest.fixture
def folder(tmp_path):
    """Return a copy of the example's folder."""
    return Path(shutil.copytree(EXAMPLE, tmp_path / "own_block"))


def test_the_page_shows_the_example_s_files():
    shown = "\n".join(PYTHON)
    for name in ("grease.py", "gravity.py"):
        assert (EXAMPLE / name).read_text(encoding="utf-8").rstrip() in shown
    entries = re.search(r"^thinning_rate.*$", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    assert entries[0] in (EXAMPLE / "mechanism.toml").read_text(encoding="utf-8")


def test_the_page_s_assembly_is_made():
    exec(compile(PYTHON[-1], str(PAGE), "exec"), {})


def test_a_block_takes_some_twenty_lines():
    for name in ("grease.py", "gravity.py"):
        body = (EXAMPLE / name).read_text(encoding="utf-8").partition("def ")[2]
        assert len(body.splitlines()) <= 25


def test_the_rates_are_those_of_the_page():
    m = load_mechanism(EXAMPLE / "mechanism.toml")
    assert {q.name for q in m.free} == {"friction.dry", "friction.grease", "load.unbalance"}
    equations, names = equations_of(m.plant), list(map(str, m.plant.states))
    x = {"i_A": 0.3, "i_B": -0.2, "alpha": 1.2, "omega": -6.0, "alpha_gear": 0.0241, "omega_gear": -0.11}
    modes = equations.mode_symbols([list(m.plant.switches[0].modes).index("backward")])
    rates = dict(zip(names, equations.rates([x[n] for n in names], [0.0, 0.0], modes, m.kernel_values()), strict=True))
    twist, twist_rate = x["alpha"] - 50 * x["alpha_gear"], x["omega"] - 50 * x["omega_gear"]
    T_rg = 913.47 / 2500 * twist + 0.39 / 2500 * twist_rate
    T_mot = 0.384 * (0.3 * np.sin(50 * 1.2) - 0.2 * np.cos(50 * 1.2))
    T_fr = -0.004 + 0.006 * -6.0 / np.sqrt(1 + 6.0 / 20.0)
    assert rates["omega"] == pytest.approx((T_mot - T_fr - T_rg) / 8.9e-6, rel=1e-12)
    assert rates["omega_gear"] == pytest.approx((50 * T_rg - 0.5 * np.sin(0.0241)) / 0.010534, rel=1e-12)


def test_it_is_simulated_like_any_other(folder, tmp_path):
    """Truth: the slow twin."""
    asked = [
        "simulate",
        str(folder),
        "--out",
        str(tmp_path / "out"),
        "--sample-rate-hz",
        "10000",
        "--duration-s",
        "0.1",
    ]
    assert CliRunner().invoke(app, asked, prog_name="mechid").exit_code == 0
    written = np.loadtxt(tmp_path / "out" / "full_46.csv", delimiter=",", skiprows=1)
    campaign = load_campaign(folder, read_records=False)
    m, command = campaign.mechanism, campaign.records[0].command
    twin = simulate_twin(
        m.plant, command.excitation(0.2), written[:, 0], m.kernel_values(), start_angle_rad=command.start_angle_rad
    )
    error = written[:, 1] - twin.y[:, 0]
    assert np.sqrt(np.mean(error**2)) <= 1e-5 * np.sqrt(np.mean(twin.y**2))
    assert simulate(campaign, sample_rate_hz=1e4, duration_s=0.1).quantity == "torque"


REFUSED = {
    "no colon": ("grease.py:grease", "grease.py", 'friction.block: found "grease.py"; write the file and the name'),
    "no file": ("grease.py:grease", "greese.py:grease", 'greese.py: there is no such file; did you mean "grease.py"?'),
    "no name": ("grease.py:grease", "grease.py:greese", 'grease.py has no "greese"; did you mean "grease"?'),
    "no block": ("grease.py:grease", "grease.py:ROTOR", "grease.py:ROTOR gives Site; it has to be a Block"),
    "law beside it": ("dry =", 'law = "stribeck"\ndry =', 'friction.block: excludes law = "stribeck"; keep one'),
    "not of it": ("dry =", "coulomb = 0.1\ndry =", "friction.coulomb: unknown key"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_wrong_is_said_with_its_place(folder, case):
    old, new, message = REFUSED[case]
    path = folder / "mechanism.toml"
    path.write_text(path.read_text().replace(old, new, 1))
    with pytest.raises(InputFileError, match=re.escape(message)) as caught:
        load_mechanism(path)
    assert str(caught.value).startswith("mechanism.toml: friction.")
    assert "\n" not in str(caught.value)


FAULTS = {
    "does not run": ("from sympy", "import nothing_such\nfrom sympy", "grease.py fails: ModuleNotFoundError"),
    "is no Python": ("def grease", "def def grease", "grease.py fails: SyntaxError"),
    "raises": ("    T_c, b", "    raise ValueError('no')\n    T_c, b", "grease.py:grease fails: ValueError: no"),
    "strange symbol": ("sliding=T_c", "sliding=symbols('T_x') * T_c", "T_x is no state, term, input or declared"),
}


@pytest.mark.parametrize("case", FAULTS)
def test_a_file_that_fails_is_named(folder, case):
    old, new, message = FAULTS[case]
    source = folder / "grease.py"
    source.write_text(source.read_text().replace(old, new, 1))
    with pytest.raises(InputFileError, match=re.escape(message)) as caught:
        load_mechanism(folder / "mechanism.toml")
    assert str(caught.value).startswith("mechanism.toml: ")


ODD = {
    "source=source)": ("source=None)", 'Declaration "dry": source: found None, no text'),
    "lower=0.0, source=source": ("lower=None, source=source", "limits: found (None, inf)"),
    '"dry"': ('"dr y"', 'key: found "dr y"; write a name'),
    "sliding=T_c * sigma": ("sliding=T_c * zoo", "which is no number"),
}


@pytest.mark.parametrize("part", ODD)
def test_a_part_that_is_none_is_named(folder, part):
    """Truth: what was put in its place."""
    other, said = ODD[part]
    text = (folder / "grease.py").read_text(encoding="utf-8")
    assert part in text
    changed = text.replace(part, other, 1).replace("import sqrt", "import zoo, sqrt")
    (folder / "grease.py").write_text(changed, encoding="utf-8")
    with pytest.raises(InputFileError) as error:
        load_mechanism(folder / "mechanism.toml")
    assert said in str(error.value)
    assert "friction.block: grease.py:grease" in str(error.value)
