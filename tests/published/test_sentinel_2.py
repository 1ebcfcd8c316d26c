"""Lines of the two gear meshes of Sentinel-2's solar array drive.

Mingione (MSc thesis, Politecnico di Milano 2021) after Alazard et al. (ESA GNC 2021): wheel 2 (74 teeth) drives wheel 3
(69), wheel 3 (75) drives wheel 4 (80); orders per turn of the array 13 616 and 14 800 of the meshes, 184, 197.3 and 185
of a tooth of wheels 2, 3 and 4; the array turns at 0.06 deg/s in tracking and at 0.205 deg/s in rewinding. Motor steps
and first ratio are not published: 200 steps a turn, and a motor on the shaft of wheel 2, are assumed. Case B of
docs/validation.md.
"""

import numpy as np
import pytest

import mechid
from mechid.budgets.files import budget_texts
from paper_estimate import estimate_of, write_estimate

RATIO = 184.0
STEPS_PER_DEG = RATIO / 1.8
SAMPLE_RATE_HZ = 25.0
WHEEL_2, WHEEL_3, WHEEL_4 = "mesh 1 driver", "mesh 1 driven", "mesh 2 driven"
"""Names by the tooth meshes of the mechanism file; wheel 3 is "mesh 2 driver" too."""
DERIVED = {
    0.06: {"mesh 1": 2.269, "mesh 2": 2.467, WHEEL_2: 0.0307, WHEEL_3: 0.0329, WHEEL_4: 0.0308},
    0.205: {"mesh 1": 7.754, "mesh 2": 8.428, WHEEL_2: 0.1048, WHEEL_3: 0.1124, WHEEL_4: 0.1053},
}
"""By the rate of the array in deg/s: frequencies in Hz."""
SIZES = {"mesh 1": 0.003, "mesh 2": 0.002, WHEEL_2: 0.004, WHEEL_3: 0.005, WHEEL_4: 0.003}


def drive(**parts):
    """Return the mechanism, with further entries of its gear; its dynamics do not matter here."""
    return mechid.make_mechanism(
        {
            "stepper": {
                "poles": 100,
                "peak_voltage": 5.7,
                "rotor_inertia": 8.9e-6,
                "coil_resistance": 9.9,
                "coil_inductance": 0.045,
                "torque_constant": 0.384,
            },
            "friction": {"static": 0.01, "coulomb": 0.01, "viscous": 1e-3},
            "gear": {
                "ratio": RATIO,
                "stiffness": 5e4,
                "damping": 20.0,
                "mesh": [{"teeth": [74, 69]}, {"teeth": [75, 80], "ratio_behind": 185}],
                **parts,
            },
            "load": {"inertia": 10.0},
        }
    )


@pytest.mark.parametrize("rate", DERIVED)
def test_the_teeth_name_the_published_lines(rate, note):
    """Derived from the published orders: tolerance 0.1 %, or half of the last digit of the rounded figure."""
    orders = {line.name: line.order for line in drive().named_lines}
    for name, derived in DERIVED[rate].items():
        found = orders[name] * rate * STEPS_PER_DEG
        note(f"Sentinel-2, array at {rate} deg/s: {name} at {found:.5f} Hz, derived {derived}")
        assert found == pytest.approx(derived, rel=1e-3, abs=5e-5)


def test_a_look_at_a_turn_of_the_array_finds_them(note):
    """Truth: sines at the derived frequencies in noise, one turn at 0.205 deg/s; amplitudes within 4 sigma."""
    rate = 0.205
    time = np.arange(round(360.0 / rate * SAMPLE_RATE_HZ)) / SAMPLE_RATE_HZ
    per_turn = {"mesh 1": 13_616.0, "mesh 2": 14_800.0, WHEEL_2: 184.0, WHEEL_3: 592.0 / 3.0, WHEEL_4: 185.0}
    turns = rate / 360.0 * time
    torque = 0.01 * np.random.default_rng(0).standard_normal(time.size)
    torque += sum(SIZES[name] * np.sin(2 * np.pi * order * turns + order) for name, order in per_turn.items())
    command = mechid.make_command("micro", microsteps=16, rate=rate * STEPS_PER_DEG)
    record = mechid.make_record("rewinding", torque, sample_rate_hz=SAMPLE_RATE_HZ, command=command)
    (seen,) = mechid.look(mechid.make_campaign(drive(), [record])).to_dict()["records"]
    found = {line["names"][0]: line for line in seen["channels"][0]["named_lines"]}
    for name, size in SIZES.items():
        line = found[name]
        note(
            f"Sentinel-2, look: {name} {1e3 * line['amplitude']:.2f} +- {1e3 * line['sigma']:.2f} mN m of {1e3 * size}"
        )
        assert abs(line["amplitude"] - size) < 4.0 * line["sigma"]
    in_spectrum = np.array([line["frequency_hz"] for line in seen["channels"][0]["lines"]])
    for name in ("mesh 1", "mesh 2"):
        nearest = in_spectrum[np.argmin(np.abs(in_spectrum - DERIVED[rate][name]))]
        assert nearest == pytest.approx(DERIVED[rate][name], rel=1e-3)


BUDGET = """
estimate = "estimate.json"
axis = "rz"
[structure]
file = "structure.toml"
coupled_below_hz = 1.0
[[mode]]
name = "tracking"
command = {{ stepping = "micro", microsteps = 16 }}
rates = [{rate}]
highest_hz = 40.0
"""
STRUCTURE = """
axis = "rz"
line_of_sight = ["x"]
[[mode]]
frequency_hz = 30.0
damping = 0.005
interface = 0.03
line_of_sight = [0.01]
"""


@pytest.mark.slow
def test_a_budget_has_them(tmp_path, note):
    """Derived: frequencies as above to 0.1 %, names in the budget's numbers and in its table of lines."""
    rate = 0.205
    errors = [{"order": name, "amplitude": 1e-6, "phase_deg": 30.0 * k} for k, name in enumerate(SIZES)]
    mechanism = drive(kinematic_error=errors)
    write_estimate(tmp_path, mechanism, estimate_of(mechanism, ("gear.damping",)))
    (tmp_path / "structure.toml").write_text(STRUCTURE, encoding="utf-8")
    (tmp_path / "budget.toml").write_text(BUDGET.format(rate=rate * STEPS_PER_DEG), encoding="utf-8")
    made = mechid.budget(tmp_path / "budget.toml")
    found = {one["name"]: one for one in made.to_dict()["modes"][0]["named_lines"]}
    for name, derived in DERIVED[rate].items():
        one = found[name]
        note(f"Sentinel-2, budget: {name} at {one['frequency_hz']:.5f} Hz, {one['torque_Nm']:.3e} N m")
        assert one["frequency_hz"] == pytest.approx(derived, rel=1e-3, abs=5e-5)
        assert one["torque_Nm"] > 0.0
    rows = "".join(budget_texts(made, made.to_dict())["harmonics.csv"]).splitlines()
    assert {row.rpartition(",")[2] for row in rows} >= {*SIZES}
