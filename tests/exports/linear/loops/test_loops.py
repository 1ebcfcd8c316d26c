"""Loops around the paper's mechanism. Truth: a coil alone, the files that are written, messages that name the pole."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.io import loadmat

from layouts import SINGLE_STEPPER, mechanism_of
from mechid.errors import InputFileError, UsageError
from mechid.exports.export import write_export
from mechid.exports.linear.linear import linear_of, linear_of_fit
from mechid.exports.linear.loops.loop_file import read_loop_file
from mechid.exports.linear.loops.margins import margins_of
from mechid.exports.linear.loops.sampled import hold, series
from mechid.exports.linear.options import Options
from mechid.exports.linear.state_space import Matrices

DRAWS = 30
CURRENT = "[current_loop]\nkp = 100.0\nki = 20000.0\nsample_rate_hz = 10000.0\n"


POSITION = """
[position_loop]
kp = 100.0
ki = 20000.0
kd = 0.4
sample_rate_hz = 1000.0
notch = { depth = 0.2 }
"""


@pytest.fixture(scope="module", autouse=True)
def few_draws():
    """Let the bands be of few draws, which is enough to see their width."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("mechid.exports.linear.linear.DRAWS", DRAWS)
        yield


@pytest.fixture(scope="module")
def write_design(tmp_path_factory):
    """Return a function that writes a quiet.toml and returns its path."""
    folder = tmp_path_factory.mktemp("design")

    def write(text, name="quiet.toml"):
        (folder / name).write_text(text, encoding="utf-8")
        return folder / name

    return write


@pytest.fixture(scope="module")
def linear(paper, write_design):
    """Return the paper's models with their current loops."""
    design = read_loop_file(write_design(CURRENT + POSITION, "both.toml"))
    return linear_of(paper, Options(rates=(), samples=2, seed=7, loop=design))


def test_the_current_loop_of_a_stuck_motor_is_that_of_its_coil(paper, linear):
    """Truth: 1/(L s + R) with the same controller; its width that of the inductance alone."""
    R, L = paper.mechanism.value("stepper.coil_resistance"), paper.mechanism.value("stepper.coil_inductance")
    coil = Matrices(np.array([[-R / L]]), np.array([[1.0 / L]]), np.eye(1), np.zeros((1, 1)))
    for phase in ("phase_a", "phase_b"):
        one = linear.loops.current["stuck"][phase]
        held = hold(coil, ("u",), ("i",), 1e-4, delayed=("u",), delay_s=1e-4)
        expected = margins_of(series(one.loop.controller, held))
        assert one.numbers.margins.gain_dB == pytest.approx(expected.gain_dB, abs=1e-6)
        assert one.numbers.margins.phase_deg == pytest.approx(expected.phase_deg, abs=1e-6)
        band = one.numbers.bands["gain_dB"]
        # At the phase crossover the loop is kp/(w L): its gain moves as the inductance does, 0.5 % here.
        assert float(band.high - band.low) == pytest.approx(4.0 * 20.0 * np.log10(1.005), rel=0.35)


def test_the_back_emf_couples_the_loops_of_a_free_motor(linear):
    """Truth: the continuous model, its inputs late by the delay and half a sample of holding."""
    model, one = linear["free"], linear.loops.current["free"]["phase_a"]
    hertz = np.array([46.0])
    rows = [model.outputs.names.index(f"current_phase_{x}") for x in "ab"]
    columns = [model.inputs.names.index(f"added_voltage_phase_{x}") for x in "ab"]
    P = model.response(hertz)[0][np.ix_(rows, columns)]
    K = one.loop.controller.response(hertz)[0, 0, 0] * np.exp(-2j * np.pi * hertz[0] * 1.5e-4)
    expected = K * (P[0, 0] - P[0, 1] * K * P[1, 0] / (1.0 + K * P[1, 1]))
    assert one.loop.open.response(hertz)[0, 0, 0] == pytest.approx(expected, rel=2e-4)
    assert abs(expected / (K * P[0, 0]) - 1.0) > 0.01


def test_the_step_ends_at_the_reference(linear):
    """Truth: the integral; the other phase returns to 0, and the voltage to R i."""
    one = linear.loops.current["stuck"]["phase_b"]
    ends = {name: float(band.value[-1]) for name, band in one.step.outputs.items()}
    assert ends["current_phase_b"] == pytest.approx(1.0, abs=0.02)
    assert ends["current_phase_a"] == pytest.approx(0.0, abs=1e-12)
    assert ends["control_added_voltage_phase_b"] == pytest.approx(9.9, rel=0.05)


def test_the_position_loop_is_around_the_model_whose_rotor_moves(linear):
    """Truth: friction holds the other; the notch stands at the drive-train mode, 46 Hz of the linear model."""
    assert list(linear.loops.position) == ["free"]
    one = linear.loops.position["free"]
    poles = np.linalg.eigvals(linear["free"].matrices.A)
    slow = np.abs(poles[poles.imag > 0]).min() / (2.0 * np.pi)
    assert one.mode_hz == pytest.approx(slow, rel=0.02)
    assert one.notch.frequency_hz == one.mode_hz
    assert one.sign == 1.0
    assert float(one.closed.step.outputs["output_angle"].value[-1]) == pytest.approx(1.0, abs=0.02)
    own, expected = one.closed.loop.open, one.closed.numbers.margins
    assert abs(own.response([expected.phase_frequency_hz])[0, 0, 0]) == pytest.approx(1.0, abs=1e-9)
    assert one.trade[0].depth is None
    assert "Position loop" in " ".join(linear.words)


def test_the_nonlinear_equations_have_the_same_margins(linear):
    """Truth: swept sines through them, 0.3 dB and 1 deg required."""
    loops = [one for model in linear.loops.current.values() for one in model.values()]
    loops.append(linear.loops.position["free"].closed)
    assert len(loops) == 5
    for one in loops:
        assert abs(one.sweep.gain_error_dB) < 0.05
        assert abs(one.sweep.phase_error_deg) < 0.1
    assert "5 of 5 loops have the same margins" in linear.words[-1]


def test_a_sensor_that_no_current_moves_is_refused(paper, write_design):
    """Truth: a motor alone has no output angle besides its rotor's."""
    alone = mechanism_of({"assembly": "current_driven_stepper", **SINGLE_STEPPER})
    driven = replace(paper, mechanism=alone, names=(), covariance=np.zeros((0, 0)), trials=())
    design = read_loop_file(write_design(POSITION, "position.toml"))
    with pytest.raises(
        InputFileError, match=r"position.toml: position_loop.sensor: the currents do not move output_angle"
    ):
        linear_of(driven, Options(rates=(), samples=0, loop=design))


def test_both_files_have_the_loops(paper, write_design, tmp_path):
    """Truth: the same numbers in both files, blocks of matching sizes, sentences with both margins."""
    options = {"rates": "none", "samples": "0", "loop": str(write_design(CURRENT))}
    done = write_export(paper, "linear", tmp_path / "out", options)
    data = json.loads((done.folder / "linear.json").read_text(encoding="utf-8"))["loops"]
    struct = loadmat(done.folder / "linear.mat")["loops"][0, 0]
    assert data["design"]["current_loop"]["timing"] == {"period_s": 1e-4, "delay_s": 1e-4}
    for model in ("stuck", "free"):
        own, there = data["current"][model]["phase_a"], struct["current"][0, 0][model][0, 0]["phase_a"][0, 0]
        assert there["margins"][0, 0]["gain_dB"][0, 0] == own["margins"]["gain_dB"]
        low, high = (own["margins"]["band"]["phase_deg"][end] for end in ("low", "high"))
        assert low < own["margins"]["phase_deg"] < high
        for name, block in own["blocks"].items():
            A, B, C, D = (np.array(block[letter]) for letter in "ABCD")
            assert A.shape == (len(B), len(B))
            assert C.shape == (len(block["outputs"]), len(A))
            assert D.shape == (len(block["outputs"]), len(block["inputs"]))
            np.testing.assert_array_equal(there["blocks"][0, 0][name][0, 0]["A"], A)
        assert len(own["bode"]["frequency_hz"]) == len(own["bode"]["phase_deg"]["low"])
    words = " ".join(done.written.words)
    assert 'Current loop of phase_a around "stuck": gain margin 12.99 dB (' in words
    figures = [f"loop_current_{model}_{phase}" for model in ("stuck", "free") for phase in ("phase_a", "phase_b")]
    assert {f"{name}.{suffix}" for name in figures for suffix in ("svg", "png")} < {
        path.name for path in done.folder.iterdir()
    }
    assert set(json.loads((done.folder / "mechid_export.json").read_text())["files"]) > {f"{figures[0]}.svg"}
    page = (done.folder / "mechid_export.html").read_text(encoding="utf-8")
    assert page.count("time after a unit step, s") == len(figures)


def test_an_unstable_loop_is_refused_with_its_pole(paper, write_design, tmp_path):
    """Truth: five times the gain is 14 dB, above the margin of 12.99 dB; nothing is written."""
    path = write_design(CURRENT.replace("100.0", "500.0"), "steep.toml")
    said = r'steep.toml: current_loop: .*"stuck" is unstable: pole at z = .* \+- .*i, 1\d\d\d Hz, growing by .* 1\.'
    with pytest.raises(InputFileError, match=said) as caught:
        write_export(paper, "linear", tmp_path / "out", {"rates": "none", "loop": str(path)})
    assert caught.value.exit_code == 3
    assert not (tmp_path / "out" / "linear.json").exists()


def test_a_current_drive_has_no_current_loop(paper, write_design):
    """Truth: its coils have no equation."""
    alone = mechanism_of({"assembly": "current_driven_stepper", **SINGLE_STEPPER})
    driven = replace(paper, mechanism=alone, names=(), covariance=np.zeros((0, 0)), trials=())
    with pytest.raises(InputFileError, match="current_loop: the mechanism's drive is given as commanded currents"):
        linear_of(driven, Options(rates=(), samples=0, loop=read_loop_file(write_design(CURRENT))))


def test_from_python_the_file_is_given_by_its_path(paper, write_design):
    """Truth: the same margins as with the design that was read; an unknown keyword is refused."""
    own = linear_of_fit(paper.fit, None, False, rates=(), samples=0, loop=write_design(CURRENT))
    assert own.loops.design.current.kp == 100.0
    with pytest.raises(TypeError, match="loops"):
        linear_of_fit(paper.fit, None, False, loops=1)
    with pytest.raises(UsageError, match='did you mean "loop"'):
        Options.read({"lop": "quiet.toml"})
