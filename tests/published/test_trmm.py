"""The solar array drive of TRMM: friction that rises twice per turn of the wave generator, and the steps it costs.

Rivera et al., 45th Aerospace Mechanisms Symposium (2020), pp. 555-571: a harmonic drive of 200:1 that lost steps every
14 s before it jammed, which the authors tie to half a turn of the motor. One turn of the array per orbit of 92.5 min is
0.0649 deg/s, half a turn of the motor then 13.87 s. The motor's constants are not published: those here are of
the size of the estimates of [Kornienko2013]_. Case C of docs/validation.md.
"""

import numpy as np
import pytest

import mechid

pytestmark = pytest.mark.slow
RATIO = 200
OUTPUT_DEG_S = 0.0649
RATE = OUTPUT_DEG_S * RATIO / 1.8
"""Full steps/s of a motor with 1.8 deg."""
HALF_TURN_S = 180.0 / (OUTPUT_DEG_S * RATIO)
SAMPLE_RATE_HZ = 200.0
LOBE_DEG = 45.0
"""Rotor angle at which friction is largest; it is again half a turn later."""
ELECTRICAL_PERIOD_DEG = 7.2


def run(friction, half_turns):
    """Return the simulated motion, with friction in N m that varies by 0.8 of its mean."""
    lobes = {"order": 2, "amplitude": 0.8, "phase_deg": 90.0 - 2.0 * LOBE_DEG}
    mechanism = mechid.make_mechanism(
        {
            "stepper": {
                "poles": 100,
                "peak_voltage": 5.7,
                "rotor_inertia": 8.9e-6,
                "coil_resistance": 9.9,
                "coil_inductance": 0.045,
                "torque_constant": 0.384,
            },
            "friction": {"static": friction, "coulomb": 0.9 * friction, "viscous": 0.0061, "position": [lobes]},
            "gear": {"ratio": RATIO, "stiffness": 5e4, "damping": 20.0},
            "load": {"inertia": 10.0},
        }
    )
    n = round(half_turns * HALF_TURN_S * SAMPLE_RATE_HZ)
    # The samples only name the channels to be simulated.
    channels = {name: np.arange(n) % 7.0 for name in ("torque", "rotor_angle")}
    command = mechid.make_command("full", rate=RATE)
    planned = mechid.make_record("drive", channels, sample_rate_hz=SAMPLE_RATE_HZ, command=command)
    return mechid.simulate(mechid.make_campaign(mechanism, [planned]))


def steps_behind(motion):
    """Return how far the rotor is behind its command at the end of each step, in full steps, (steps,)."""
    time, angle = np.asarray(motion.time), np.degrees(motion.values["rotor_angle"])
    made = np.floor(RATE * time + 1e-9).astype(int)
    last = np.flatnonzero(np.diff(made))
    return made[last] - angle[last] / 1.8


def period_s(values):
    """Return the period of a series with a value per step, by least squares of three harmonics over periods."""
    step = np.arange(values.size)
    periods = np.arange(90.0, 110.0, 0.05)

    def misfit(period):
        turns = 2j * np.pi * np.outer(step, [1, 2, 3]) / period
        waves = np.hstack((np.ones((values.size, 1)), np.exp(turns).real, np.exp(turns).imag))
        return float(np.linalg.lstsq(waves, values, rcond=None)[1][0])

    return periods[np.argmin([misfit(period) for period in periods])] / RATE


@pytest.fixture(scope="module")
def followed():
    """Return the motion at the largest friction, in steps of 0.01 N m, with which no step is lost."""
    return run(0.09, 9.0)


def test_the_rotor_lags_most_every_half_turn(followed, note):
    """Published: 14 s; derived from the orbit: 13.87 s. Tolerance 0.5 %."""
    behind = steps_behind(followed)
    found = period_s(behind[100:])
    note(f"TRMM, the rotor lags most every {found:.3f} s, up to {behind.max():.2f} full steps; derived 13.87 s")
    assert found == pytest.approx(HALF_TURN_S, rel=0.005)
    assert pytest.approx(14.0, rel=0.01) == HALF_TURN_S
    assert behind.max() < 1.0


def test_the_torque_has_lines_half_a_turn_beside_those_of_the_steps(followed, note, tmp_path):
    """Derived: lines at the step rate plus and minus 1/13.87 s, in what `mechid look` lists. Tolerance 0.5 %."""
    file = tmp_path / "drive.csv"
    noisy = followed.torque + 1e-4 * np.random.default_rng(0).standard_normal(followed.torque.size)
    columns = np.stack((followed.time, noisy), axis=1)
    np.savetxt(file, columns, delimiter=",", header="time_s,torque_Nm", comments="")
    (record,) = mechid.look(file).to_dict()["records"]
    lines = np.array([line["frequency_hz"] for line in record["channels"][0]["lines"]])
    beside = lines[np.abs(lines - RATE) < 1.5 / HALF_TURN_S]
    assert beside.size == 3
    periods = 1.0 / np.diff(beside)
    note(f"TRMM, lines beside that of the step rate: {periods[0]:.3f} and {periods[1]:.3f} s, derived 13.87 s")
    assert periods == pytest.approx(HALF_TURN_S, rel=0.005)


def test_steps_are_lost_at_a_lobe(note):
    """Published: steps are lost where friction is largest. In the model the first lobe that stops the rotor keeps it.

    It then loses an electrical period of four steps each time that the field has gone round, and not every 14 s.
    """
    motion = run(0.1, 3.0)
    angle = np.degrees(motion.values["rotor_angle"])
    lost = np.round(steps_behind(motion) / 4.0)
    first = np.flatnonzero(lost)[0] / RATE
    note(
        f"TRMM, with 11 % more friction: lost from {first:.2f} s on at {angle.max():.1f} deg, every {4.0 / RATE:.3f} s"
    )
    assert angle.max() == pytest.approx(LOBE_DEG, abs=ELECTRICAL_PERIOD_DEG / 2.0)
    assert first == pytest.approx(LOBE_DEG / (OUTPUT_DEG_S * RATIO), abs=4.0 / RATE)
    assert np.diff(lost[round(RATE * HALF_TURN_S) :: 4]) == pytest.approx(1.0)
