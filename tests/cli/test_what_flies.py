"""What was identified is what flies: every mechanism from the file that identify left to its budget, or refused."""

import json

import numpy as np
import pytest

from flown import FULL, simulated
from layouts import LAYOUTS, SINGLE_STEPPER, changed, mechanism_of, paper_table
from mechid.campaign import load_mechanism
from mechid.campaign.campaign import record_parameter_name
from paper_estimate import estimate_of, write_estimate
from whole_estimate import whole_estimate

STRUCTURE = """\
axis = "rz"
line_of_sight = ["x"]
[[mode]]
frequency_hz = 300.0
damping = 0.005
interface = 0.15
line_of_sight = [0.04]
"""
"""Stiff: with `coupled_below_hz` below its mode nothing is joined, and one kernel is enough."""
BUDGET = """\
estimate = "estimate.json"
axis = "rz"
{flight}
[structure]
file = "structure.toml"
coupled_below_hz = {coupled}
[[mode]]
name = "slew"
command = {{ stepping = "full", rate = {rate}, start_angle_deg = 45.0 }}
[[requirement]]
name = "stability"
index = "RPE"
window_s = 0.1
axis = "x"
limit_rad = 1e-4
interpretation = "temporal"
confidence = 0.95
evaluation_period_s = 60.0
"""


def left(folder, changes, free, *, flight="", coupled=10.0, rate=46.0, table=None):
    """Write what identify leaves of a mechanism, and a budget of it; return the budget's path."""
    mechanism = mechanism_of(table or changed(paper_table(), changes))
    write_estimate(folder, mechanism, estimate_of(mechanism, free))
    (folder / "structure.toml").write_text(STRUCTURE, encoding="utf-8")
    path = folder / "budget.toml"
    path.write_text(BUDGET.format(flight=flight, coupled=coupled, rate=rate), encoding="utf-8")
    return path


def line_of(folder, order):
    rows = (folder / "out" / "harmonics.csv").read_text(encoding="utf-8").splitlines()
    names = rows[0].split(",")
    found = [dict(zip(names, row.split(","), strict=True)) for row in rows[1:]]
    return next(float(r["torque_amplitude_Nm"]) for r in found if float(r["order"]) == order)


@pytest.mark.slow
def test_output_friction_flies(run, tmp_path):
    """Truth: the line of the same file simulated for 8 s; that without the friction, seven times it, was silent."""
    changes = {"output_friction": {"coulomb": 0.3}, "housing": None}
    budget = left(tmp_path, changes, ["output_friction.coulomb"])
    result = run("budget", budget, "--out", tmp_path / "out")
    assert result.exit_code == 0, result.stderr
    torque = simulated(mechanism_of(changed(paper_table(), changes)), FULL, seconds=8.0, rate_hz=46.0 * 20_000)
    last = torque[-20_000 * 46 - 1 : -1]
    assert line_of(tmp_path, 1.0) == pytest.approx(abs(2.0 / last.size * np.fft.rfft(last)[46]), rel=1e-4)
    assert line_of(tmp_path, 1.0) < 0.2


FREE = {
    "transducer": ({"transducer": {"law": "gain", "gain": 1.1}}, ["transducer.gain"]),
    "imbalance": (LAYOUTS["imbalance"], ["stepper.imbalance.torque_constant"]),
    "detent hysteresis": (LAYOUTS["detent hysteresis"], ["stepper.detent_hysteresis.torque"]),
    "magnet": (LAYOUTS["magnet"], ["stepper.magnet.detent_per_K"]),
    "saliency": (LAYOUTS["saliency"], ["stepper.saliency.share"]),
    "kinematic_error": (LAYOUTS["kinematic_error"], ["gear.kinematic_error.0.amplitude"]),
    "torque_harmonic": (LAYOUTS["torque_harmonic"], ["stepper.torque_harmonic.1.phase_deg"]),
    "flexible load": (LAYOUTS["flexible load"], ["load.mode.0.frequency"]),
    "stribeck": (LAYOUTS["stribeck"], ["friction.stribeck_rate"]),
    "backlash": (LAYOUTS["backlash"], ["gear.backlash"]),
    "current drive": (LAYOUTS["current drive"], ["stepper.peak_current"]),
    "cable": (LAYOUTS["cable"], ["load.cable.hysteresis"]),
    "unbalance": (LAYOUTS["unbalance"], ["load.unbalance.amplitude"]),
    "lugre": (LAYOUTS["lugre"], ["friction.bristle_stiffness"]),
    "load_dependent": (LAYOUTS["load_dependent"], ["friction.load_share"]),
    "directional": (LAYOUTS["directional"], ["friction.asymmetry"]),
    "piecewise_linear": (LAYOUTS["piecewise_linear"], ["gear.stiffness_2"]),
    "anti_alias": (LAYOUTS["test stand"], ["anti_alias.frequency", "charge_amplifier.time_constant"]),
}
QUICK = ("transducer",)


@pytest.mark.parametrize("name", [n if n in QUICK else pytest.param(n, marks=pytest.mark.slow) for n in FREE])
def test_every_block_flies_with_what_is_free_of_it(run, tmp_path, name):
    """Truth: exit 0, and the error of what is free is in the band where it flies, or is said to stay on the bench."""
    changes, free = FREE[name]
    budget = left(tmp_path, changes, [*free, "gear.ratio"][: len(free)])
    result = run("budget", budget, "--out", tmp_path / "out")
    assert result.exit_code == 0, result.stderr
    data = json.loads((tmp_path / "out" / "budget.json").read_text(encoding="utf-8"))
    shares = data["requirements"][0]["variance_shares"]
    stays = {f"[{n.rpartition('.')[0]}]" for n in free} <= data["flight"]["left_on_bench"].keys()
    assert stays or set(free) <= shares.keys()
    said = " ".join(result.stdout.split())
    for what, why in data["flight"]["left_on_bench"].items():
        assert f"left on the bench: {what}: {why}" in said


def test_what_belongs_to_a_record_stays_with_a_line(run, tmp_path):
    """Truth: a free time offset, as every real bench has one, and a gain of one record: neither flies."""
    own = [record_parameter_name("slow", "time_offset_s"), record_parameter_name("slow", "transducer.gain")]
    budget = left(tmp_path, {"housing": None}, ["gear.stiffness"])
    path = tmp_path / "estimate.json"
    content = json.loads(path.read_text(encoding="utf-8"))
    for name in own:
        content["parameters"][name] = {"value": 1e-4, "std_error": 1e-6, "status": "free"}
    names = [*content["correlation"]["names"], *own]
    content["correlation"] = content["covariance"] = {"names": names, "matrix": np.eye(3).tolist()}
    path.write_text(json.dumps(whole_estimate(content)), encoding="utf-8")
    result = run("budget", budget, "--out", tmp_path / "out")
    assert result.exit_code == 0, result.stderr
    for name in own:
        assert f"left on the bench: {name}: it belongs to one record" in " ".join(result.stdout.split())


@pytest.mark.slow
def test_an_own_friction_block_flies_as_itself(run, tmp_path):
    """Truth: a law whose keys are those of Coulomb friction and which brakes three times as much."""
    (tmp_path / "own.py").write_text(
        "from sympy import symbols\n"
        "from mechid.parameter import Declaration\n"
        "from mechid.plant.friction import ROTOR, set_valued\n"
        "def law():\n"
        "    T_s, T_c, b = symbols('T_s T_c b')\n"
        "    keys = (('static', T_s, 'N m'), ('coulomb', T_c, 'N m'), ('viscous', b, 'N m s/rad'))\n"
        "    own = tuple(Declaration(key=k, symbol=s.name, unit=u, meaning=k, lower=0.0) for k, s, u in keys)\n"
        "    sliding = 3 * T_c * ROTOR.sigma + 3 * b * ROTOR.omega\n"
        "    return set_valued(ROTOR, own, sliding=sliding, holds=(3 * T_s, 3 * T_s))\n",
        encoding="utf-8",
    )
    tables = {"own": {"friction": {"block": f"{tmp_path}/own.py:law"}}, "thrice": {"friction": {}}, "plain": {}}
    for key, times in (("static", 3.0), ("coulomb", 3.0), ("viscous", 3.0)):
        tables["thrice"]["friction"][key] = times * paper_table()["friction"][key]
    sizes = {}
    for name, changes in tables.items():
        folder = tmp_path / name
        folder.mkdir()
        budget = left(folder, {**changes, "housing": None}, ["gear.stiffness"])
        result = run("budget", budget, "--out", folder / "out")
        assert result.exit_code == 0, result.stderr
        sizes[name] = line_of(folder, 1.0)
    assert sizes["own"] == pytest.approx(sizes["thrice"], rel=1e-9)
    assert abs(sizes["own"] / sizes["plain"] - 1.0) > 0.01


@pytest.mark.parametrize(
    ("spoilt", "said"),
    [
        ("edited", "mechanism.toml is not the file that identify wrote beside estimate.json: identify anew"),
        ("absent", "mechanism.toml: there is no such file; identify writes it beside estimate.json"),
        (
            "plant",
            "estimate.json: provenance.plant: the equations of mechanism.toml differ from those that were",
        ),
        ("unsigned", "estimate.json: provenance.mechanism_sha256: missing; an earlier mechid wrote it, identify anew"),
    ],
)
def test_only_what_was_identified_flies(refused, tmp_path, spoilt, said):
    """Truth: the digests that identify leaves, of the file and of the equations."""
    budget = left(tmp_path, {}, ["gear.stiffness"])
    file, path = tmp_path / "mechanism.toml", tmp_path / "estimate.json"
    content = json.loads(path.read_text(encoding="utf-8"))
    if spoilt == "edited":
        file.write_text(file.read_text(encoding="utf-8").replace("5.7", "5.8"), encoding="utf-8")
    elif spoilt == "absent":
        file.unlink()
    elif spoilt == "plant":
        content["provenance"]["plant"] = "0" * 64
    else:
        del content["provenance"]["mechanism_sha256"]
    path.write_text(json.dumps(content), encoding="utf-8")
    assert said in refused(3, "budget", budget, "--out", tmp_path / "out")
    assert not (tmp_path / "out").exists()


MEASURED = {"stepper": {"drive": "measured_voltage", "peak_voltage": None}, "housing": None}


def test_a_measured_drive_flies_on_a_command_of_given_voltage(run, refused, tmp_path):
    """Truth: the same mechanism on the drive of its command at that voltage."""
    bench = left(tmp_path, MEASURED, ["gear.stiffness"])
    line = refused(3, "budget", bench, "--out", tmp_path / "out")
    assert "stepper.peak_voltage: on the bench measured channels drove the motor" in line
    assert "give [flight] peak_voltage" in line
    budget = left(tmp_path, MEASURED, ["gear.stiffness"], flight="[flight]\npeak_voltage = 5.7")
    assert run("budget", budget, "--out", tmp_path / "out").exit_code == 0
    there = tmp_path / "commanded"
    there.mkdir()
    run("budget", left(there, {"housing": None}, ["gear.stiffness"]), "--out", there / "out")
    assert line_of(tmp_path, 1.0) == pytest.approx(line_of(there, 1.0), rel=1e-12)


def test_what_no_step_command_drives_cannot_fly(refused, tmp_path):
    """Truth: an assembly under a measured torque; one sentence with the block and the remedy."""
    table = {
        "assembly": "two_mass_drive",
        "motor": {"inertia": 1e-4},
        "drive": {},
        "friction": {"static": 0.01, "coulomb": 0.005, "viscous": 1e-3},
        "load": {"inertia": 1e-3},
        "gear": {"ratio": 1, "stiffness": 50.0, "damping": 0.1},
    }
    budget = left(tmp_path, {}, ["gear.stiffness"], table=table)
    line = refused(3, "budget", budget, "--out", tmp_path / "out")
    assert 'assembly = "two_mass_drive": block drive follows a measured torque' in line


@pytest.mark.slow
def test_a_stepper_alone_flies_with_its_load(run, tmp_path):
    """Truth: the flight's inertia takes the place of what the stepper moves, which is its rotor with what is on it."""
    table = {"assembly": "current_driven_stepper", **SINGLE_STEPPER}
    budget = left(tmp_path, {}, ["stepper.torque_constant"], table=table, flight="[flight]\nload_inertia = 8e-5")
    result = run("budget", budget, "--out", tmp_path / "out")
    assert result.exit_code == 0, result.stderr
    data = json.loads((tmp_path / "out" / "budget.json").read_text(encoding="utf-8"))
    assert data["modes"][0]["torque_rms_Nm"] > 0.0


@pytest.mark.slow
def test_an_own_load_flies_one_way_and_says_so(run, tmp_path):
    """Truth: the block is written for a base at rest; two-way is refused in a sentence, one-way is worked out."""
    (tmp_path / "own.py").write_text(
        "from sympy import symbols\n"
        "from mechid.parameter import Declaration\n"
        "from mechid.plant.block import Block\n"
        "def load():\n"
        "    a, v, T, J, G, p, t = symbols('alpha_gear omega_gear T_applied_in J_m G p theta_0')\n"
        "    J_d = Declaration(key='inertia', symbol='J_m', unit='kg m2', meaning='inertia', lower=0.0)\n"
        "    return Block(name='load', table='load', declarations=(J_d,), inputs=(T,), rates={a: v, v: T / J},\n"
        "                 initial={a: t / (p / 2) / G, v: 0},\n"
        "                 outputs={'alpha_gear': a, 'omega_gear': v, 'T_load': T})\n",
        encoding="utf-8",
    )
    changes = {"load": {"block": f"{tmp_path}/own.py:load"}, "housing": None}
    budget = left(tmp_path, changes, ["gear.stiffness"], coupled=350.0)
    result = run("budget", budget, "--out", tmp_path / "out")
    assert result.exit_code == 0, result.stderr
    assert "load: the block of your own is written for a base at rest" in " ".join(result.stdout.split())
    data = json.loads((tmp_path / "out" / "budget.json").read_text(encoding="utf-8"))
    assert data["requirements"][0]["decided"]["coupling"] == "one-way"
    assert load_mechanism(tmp_path / "mechanism.toml").plant.layout.own.keys() == {"load"}


@pytest.mark.parametrize(
    ("flight", "said"),
    [
        (
            "values = { housing.gain = 3.0 }",
            "flight.values: housing.gain stays on the bench: its filter has no",
        ),
        ("values = { anti_alias.frequency = 3.0 }", "flight.values: anti_alias.frequency stays on the bench"),
        ("peak_current = 0.5", "flight.values: unknown parameter stepper.peak_current"),
        ("spread = { stepper.back_emf_constant = 0.1 }", "flight.spread: stepper.back_emf_constant follows another"),
        ("values = { friction.static = 0.0 }", "flight: friction.static: 0 is below friction.coulomb"),
    ],
)
def test_a_flight_that_cannot_be_is_one_line(refused, tmp_path, flight, said):
    tied = {"stepper": {"back_emf_constant": None}}
    budget = left(tmp_path, tied, ["gear.stiffness"], flight=f"[flight]\n{flight}")
    assert said in refused(3, "budget", budget, "--out", tmp_path / "out")
