"""linear.json and linear.mat: what they hold, as others read it; the forcing beside the tables' lines; bad input."""

import json
import shutil
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from scipy.io import loadmat

from layouts import SINGLE_STEPPER, changed, mechanism_of, paper_table
from mechid.budgets.emission import line_sigmas
from mechid.errors import FitError, InputFileError, UsageError
from mechid.exports.export import write_export
from mechid.exports.forcing import estimate_on_base, forcing
from mechid.exports.linear.fraction import fraction
from mechid.exports.linear.linear import linear_of
from mechid.exports.linear.mat import write_mat
from mechid.exports.linear.options import Options
from mechid.exports.stepping import steppings
from mechid.identification.result.grade import Grade

RATES = (23.0, 46.0)
OWN = changed(paper_table(), {"stepper": {"back_emf_constant": None}})


@pytest.fixture(scope="module")
def linear(paper):
    """Return the paper's linear models and its forcing at two rates."""
    return linear_of(paper, Options(rates=RATES, samples=3, seed=7))


@pytest.fixture(scope="module")
def done(paper, tmp_path_factory):
    """Return the same as written."""
    return write_export(paper, "linear", tmp_path_factory.mktemp("linear"), Options(rates=RATES, samples=3, seed=7))


def test_files_and_what_is_said(done):
    """Truth: the contract of the files; what was checked; the supply's limit and what stays on the bench are said."""
    said = json.loads((done.folder / "mechid_export.json").read_text(encoding="utf-8"))
    assert sorted(said["files"]) == ["linear.json", "linear.mat", "mechid_uss.m"]
    assert all((done.folder / name).is_file() for name in said["files"])
    assert said["checked"]["largest_error"] < 1e-4
    assert "nonlinear equations" in said["checked"]["against"]
    words = " ".join(said["words"])
    for part in ("45 electrical degrees", "[housing]", "[friction] has 0.008 N m more", "The supply lets", "2 rates"):
        assert part in words


def test_both_files_hold_the_model(done, linear):
    """Truth: the same linearisation made again in memory, to the last bit."""
    data = json.loads((done.folder / "linear.json").read_text(encoding="utf-8"))
    mat = loadmat(done.folder / "linear.mat")
    assert data["format"] == "mechid-linear/1"
    about = mat["about"][0, 0]
    assert json.loads(about["provenance"][0]) == data["provenance"] == dict(linear.provenance)
    assert [str(cell[0]) for cell in about["words"].ravel()] == data["words"] == list(linear.words)
    assert data["uncertain"]["names"] == [str(cell[0]) for cell in mat["uncertain"][0, 0]["names"].ravel()]
    np.testing.assert_array_equal(mat["uncertain"][0, 0]["covariance"], linear.uncertain.covariance)
    for name, model in linear.models.items():
        own, struct = data["models"][name], mat[name][0, 0]
        for letter, matrix, slopes, draws in zip(
            "ABCD", model.matrices.all, model.by_parameter.all, model.samples.all, strict=True
        ):
            np.testing.assert_array_equal(np.reshape(own[letter], matrix.shape), matrix)
            np.testing.assert_array_equal(struct[letter].reshape(matrix.shape), matrix)
            np.testing.assert_array_equal(np.reshape(own["by_parameter"][letter], slopes.shape), slopes)
            np.testing.assert_array_equal(struct["by_parameter"][0, 0][letter], np.moveaxis(slopes, 0, -1))
            np.testing.assert_array_equal(struct["samples"][0, 0][letter], np.moveaxis(draws, 0, -1))
        assert [str(cell[0]) for cell in struct["outputs"].ravel()] == list(model.outputs.names)


def test_forcing_is_that_of_the_steady_states(paper, linear):
    """Truth: the steady states themselves, which are held against long simulations; nothing large is left out."""
    estimate = estimate_on_base(paper)
    for one, way in zip(linear.forcing, steppings(paper.trials), strict=True):
        states = forcing(estimate, way, np.array(RATES)).largest
        assert one.name == way.name
        for k, state in enumerate(states):
            for order, line, sigma in zip(one.orders, one.lines[k], one.sigma[k], strict=True):
                found = np.flatnonzero(np.isclose(state.step_orders, order))
                assert found.size <= 1
                if found.size:
                    assert line == state.lines[found[0]]
                    assert sigma == line_sigmas(estimate, state)[found[0]]
                else:
                    assert np.isnan(line)
            left = [not np.isclose(one.orders, order).any() for order in state.step_orders]
            assert np.abs(state.lines[left]).max(initial=0.0) <= 0.01 * np.nanmax(np.abs(one.lines))
        here = np.nan_to_num(one.by_uncertain[1])
        unit = np.nan_to_num(one.lines[1] / np.maximum(np.abs(one.lines[1]), 1e-300))
        slope = (np.conj(unit)[:, None] * here).real
        own = np.sqrt(np.einsum("qi,ij,qj->q", slope, linear.uncertain.covariance, slope))
        assert (own <= np.nan_to_num(one.sigma[1]) * (1.0 + 1e-12)).all()


def test_without_records_there_is_no_forcing(paper):
    """Truth: nothing is known of the way of stepping; the motor then holds 0 degrees."""
    alone = linear_of(replace(paper, trials=()), Options(samples=0))
    assert alone.forcing == ()
    assert alone.held.command.start_angle_deg == 0.0
    assert "No forcing" in alone.words[-1]


def test_what_differs_in_flight(paper):
    """Truth: a stuck load of 35 kg m2 swings at sqrt(K/J); what is given has no error of the estimate."""
    values = {"load.inertia": 35.0, "gear.stiffness": 5.0e4}
    flown = linear_of(paper, Options(rates=(), samples=0, values=values))
    roots = np.linalg.eigvals(flown["stuck"].matrices.A)
    assert np.abs(roots[np.abs(roots.imag) > 0]) == pytest.approx(np.sqrt(5.0e4 / 35.0), rel=1e-9)
    assert "gear.stiffness" not in flown.uncertain.names
    assert "In flight load.inertia = 35, gear.stiffness = 50000." in flown.words


def test_an_angle_of_ones_own(paper):
    """Truth: the coils hold U cos of it."""
    model = linear_of(paper, Options(rates=(), samples=0, start_angle_deg=0.0))["free"]
    assert model.limits["added_voltage_phase_a"] == (pytest.approx(0.0), pytest.approx(2.0 * 5.7))


def test_scipy_has_the_same_response(linear):
    """Truth: SciPy's own frequency response."""
    model, hertz = linear["free"], np.array([5.0, 46.0])
    system = model.to_scipy()
    here = model.response(hertz)
    for k, f in enumerate(hertz):
        s = 2j * np.pi * f
        own = system.C @ np.linalg.solve(s * np.eye(6) - system.A, system.B) + system.D
        np.testing.assert_allclose(own, here[k], rtol=1e-12)


def test_python_control_has_names_and_the_same_response(linear):
    """Truth: python-control's own evaluation, and signals by name."""
    control = pytest.importorskip("control")
    system = linear["free"].to_control()
    assert isinstance(system, control.StateSpace)
    assert tuple(system.input_labels) == linear["free"].inputs.names
    assert tuple(system.output_labels) == linear["free"].outputs.names
    assert tuple(system.state_labels) == linear["free"].states.names
    one = system[system.output_index["torque"], system.input_index["output_torque"]]
    assert one(2j * np.pi * 46.0) == pytest.approx(linear["free"].response([46.0])[0, 0, 2], rel=1e-9)


def test_without_python_control(linear, monkeypatch):
    """Truth: a message that says what to install, and the arguments for whoever calls it elsewhere."""
    monkeypatch.setitem(sys.modules, "control", None)
    with pytest.raises(UsageError, match=r'pip install "mechid\[control\]"'):
        linear["free"].to_control()
    assert linear["stuck"].control_names()["states"][0] == "current_phase_a"


SCRIPT = """
pkg load control
load linear.mat
sys = ss(free.A, free.B, free.C, free.D, free.names{:});
names = {get(sys, 'stname'){:}, get(sys, 'inname'){:}, get(sys, 'outname'){:}};
printf('%s ', names{:}); printf('\\n');
H = freqresp(sys, 2 * pi * 46);
printf('%.15g ', real(H), imag(H)); printf('\\n');
u = mechid_uss(free);
H = freqresp(u, 2 * pi * 46);
printf('%.15g ', real(H), imag(H)); printf('\\n');
"""
UREAL = "function d = ureal(name, nominal, varargin)\n  d = 0.5;\nend\n"
"""In place of Robust Control Toolbox's uncertain number: its value at half a standard deviation."""


def octave_with_control():
    """Return the path of an Octave that has its control package, or nothing."""
    program = shutil.which("octave-cli")
    asked = program and subprocess.run(
        [program, "--no-gui", "--quiet", "--eval", "pkg load control"], capture_output=True, check=False, timeout=120
    )
    return program if asked and asked.returncode == 0 else None


def test_octave_opens_it(linear, tmp_path):
    """Truth: Octave's control package: one call, the names, the response; and the uncertain one at given deltas."""
    program = octave_with_control()
    if program is None:
        pytest.skip("needs Octave with its control package")
    exported_to = tmp_path / "linear.mat"
    write_mat(linear, exported_to)
    from mechid.exports.linear.mat import UNCERTAIN_SS

    (tmp_path / "mechid_uss.m").write_text(UNCERTAIN_SS, encoding="utf-8")
    (tmp_path / "ureal.m").write_text(UREAL, encoding="utf-8")
    (tmp_path / "run.m").write_text(SCRIPT, encoding="utf-8")
    run = subprocess.run(
        [program, "--no-gui", "--quiet", "run.m"],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
        timeout=120,
    )
    lines = run.stdout.splitlines()
    model = linear["free"]
    assert lines[0].split() == [*model.states.names, *model.inputs.names, *model.outputs.names], run.stderr
    parts = fraction(model)
    for line, matrices in ((lines[1], model.matrices), (lines[2], parts.at(np.full(parts.sizes.size, 0.5)))):
        numbers = np.array([float(number) for number in line.split()])
        shape = (len(model.inputs.names), len(model.outputs.names))
        got = (numbers[: numbers.size // 2] + 1j * numbers[numbers.size // 2 :]).reshape(shape).T
        s = 2j * np.pi * 46.0
        expected = matrices.C @ np.linalg.solve(s * np.eye(6) - matrices.A, matrices.B) + matrices.D
        np.testing.assert_allclose(got, expected, rtol=1e-9, atol=1e-12 * np.abs(expected).max())


def test_a_motor_alone_on_a_current_drive(paper, tmp_path):
    """Truth: stuck it has no states, the torque on its shaft is the one on its base; known values have no deltas."""
    alone = mechanism_of({"assembly": "current_driven_stepper", **SINGLE_STEPPER})
    what = replace(paper, mechanism=alone, names=(), covariance=np.zeros((0, 0)))
    write_export(what, "linear", tmp_path, Options(rates=(), samples=2))
    stuck = json.loads((tmp_path / "linear.json").read_text(encoding="utf-8"))["models"]["stuck"]
    assert stuck["A"] == []
    row, column = stuck["outputs"]["names"].index("torque"), stuck["inputs"]["names"].index("output_torque")
    assert stuck["D"][row][column] == 1.0
    assert stuck["inputs"]["names"][0] == "added_current_phase_a"
    assert stuck["fraction"]["sizes"] == []


OWN_LOAD = """
from sympy import symbols
from mechid.parameter import Declaration
from mechid.plant.block import Block


def load(push=None):
    a, v, T, J, G, p, t = symbols('alpha_gear omega_gear T_applied_in J_m G p theta_0')
    J_d = Declaration(key='inertia', symbol='J_m', unit='kg m2', meaning='inertia', lower=0.0)
    pushes = (push,) if push is not None else ()
    return Block(name='load', table='load', declarations=(J_d,), inputs=(T, *pushes),
                 rates={a: v, v: (T + sum(pushes)) / J}, initial={a: t / (p / 2) / G, v: 0},
                 outputs={'alpha_gear': a, 'omega_gear': v, 'T_load': T})


def pushed():
    return load(symbols('output_torque'))
"""


@pytest.mark.parametrize("name", ["load", "pushed"])
def test_a_load_of_ones_own(paper, tmp_path, name):
    """Truth: it has the inputs that its block declares; what is lacking is said; else it is the library's load."""
    (tmp_path / "own.py").write_text(OWN_LOAD, encoding="utf-8")
    table = changed(OWN, {"load": {"block": f"{tmp_path}/own.py:{name}"}, "housing": None})
    own = linear_of(replace(paper, mechanism=mechanism_of(table)), Options(rates=(), samples=0))
    words = " ".join(own.words)
    assert "The base's acceleration is no input: load: the block of your own" in words
    assert ("The torque on the output is no input" in words) == (name == "load")
    phases = ("added_voltage_phase_a", "added_voltage_phase_b")
    assert own["free"].inputs.names == (*phases, *(["output_torque"] if name == "pushed" else []))
    library = linear_of(paper, Options(rates=(), samples=0))["free"].response([30.0])
    response = own["free"].response([30.0])
    np.testing.assert_allclose(response, library[:, :, : response.shape[2]], rtol=1e-9, atol=1e-15)


def test_the_same_seed_gives_the_same_file(paper, linear):
    """Truth: everything in it is worked out from the estimate."""
    again = linear_of(paper, Options(rates=RATES, samples=3, seed=7))
    assert again.to_dict() == linear.to_dict()


def test_assemblies_that_no_command_steps(paper):
    """Truth: one line, with what to do."""
    table = {
        "assembly": "direct_torque_drive",
        "load": {"inertia": 0.01},
        "friction": {"static": 0.01, "coulomb": 0.005, "viscous": 0.01},
    }
    with pytest.raises(InputFileError, match="follows a measured torque"):
        linear_of(replace(paper, mechanism=mechanism_of(table)))
    measured = changed(OWN, {"stepper": {"drive": "measured_voltage", "peak_voltage": None}, "housing": None})
    other = replace(paper, mechanism=mechanism_of(measured))
    with pytest.raises(InputFileError, match=r"give --option stepper\.peak_voltage=VALUE"):
        linear_of(other)
    given = linear_of(other, Options(rates=(), samples=0, values={"stepper.peak_voltage": 5.7}))
    assert given["free"].limits["added_voltage_phase_b"][1] == pytest.approx(5.7 * (1.0 - np.sin(np.pi / 4)))


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"rate": "5"}, 'found "rate"; did you mean "rates"?'),
        ({"rates": "5,x"}, 'rates: found "x"'),
        ({"rates": "0"}, "rates: found 0; write full steps/s above 0"),
        ({"samples": "1.5"}, 'samples: found "1.5"; write a whole number'),
        ({"samples": "-1"}, "samples: found -1"),
        ({"seed": "-1"}, "seed: found -1"),
        ({"load.inertia": "heavy"}, 'load.inertia: found "heavy"'),
    ],
)
def test_options_that_cannot_be(given, said):
    """Truth: what was found, and what to write."""
    with pytest.raises(UsageError) as error:
        Options.read(given)
    assert said in str(error.value)


def test_options_as_texts():
    """Truth: written out."""
    given = {"rates": "46,5", "samples": "2", "start_angle_deg": "-30", "load.inertia": "35"}
    own = Options(rates=(5.0, 46.0), samples=2, start_angle_deg=-30.0, values={"load.inertia": 35.0})
    assert Options.read(given) == own
    assert Options.read({"rates": "none"}).rates == ()


def test_values_that_cannot_be(paper):
    """Truth: the nearest parameter, the physical limit."""
    with pytest.raises(UsageError, match=r'load\.inertai; did you mean "load\.inertia"'):
        linear_of(paper, Options(values={"load.inertai": 1.0}))
    with pytest.raises(UsageError, match=r"load\.inertia: found -1; write a number from 0 to inf"):
        linear_of(paper, Options(rates=(), values={"load.inertia": -1.0}))
    with pytest.raises(UsageError, match="divide by 0"):
        linear_of(paper, Options(rates=(), values={"load.inertia": 0.0}))


def test_a_fit_that_failed(paper):
    """Truth: its values are not handed on."""
    from mechid.exports.handover import handover

    failed = replace(paper.fit, grade=Grade.FAILED)
    with pytest.raises(FitError, match="--anyway"):
        handover(failed, None)
    assert handover(failed, None, anyway=True).provenance["grade"] == "failed"
