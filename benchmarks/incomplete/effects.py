"""The effects that a bench has and its mechanism file lacks: what each is, and how its size is drawn.

A bench's effect is a name of the table, several of them joined by "+", or `NOTHING`.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

Size = Mapping[str, float]
Draw = Callable[[np.random.Generator], Size]
"""From a generator to numbers in SI units: fields of `plant.Values`, or of `instruments.Instruments`."""


@dataclass(frozen=True)
class Effect:
    """One effect.

    Attributes
    ----------
    words : str
        What it is.
    draw : callable
    in_library : bool
        Whether a block of mechid holds it.
    in_mechanism : bool
        Whether the mechanism itself has it, and not the rig, the supply of a test or the instruments.
    reason : str
        Hardware that fixes the size; empty in `EFFECTS`, whose ranges are multiples of what the noise shows.
    """

    words: str
    draw: Draw
    in_library: bool = True
    in_mechanism: bool = True
    reason: str = ""


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    return math.exp(rng.uniform(math.log(low), math.log(high)))


def signed(rng: np.random.Generator, low: float, high: float) -> float:
    return float(rng.choice([-1.0, 1.0])) * log_uniform(rng, low, high)


def phase(rng: np.random.Generator) -> float:
    return rng.uniform(-math.pi, math.pi)


def _detent(rng: np.random.Generator) -> Size:
    period_deg = float(rng.choice([0.9, 7.2]))
    return {
        "detent_order_3": 360.0 / period_deg,
        "detent_3": log_uniform(rng, 5e-4, 5e-3),
        "detent_phase_3": phase(rng),
    }


def _torque_harmonic(rng: np.random.Generator) -> Size:
    order = float(rng.choice([3, 5]))
    return {"harmonic_order": order, "harmonic": log_uniform(rng, 3e-3, 3e-2), "harmonic_phase": phase(rng)}


def _detent_between(rng: np.random.Generator) -> Size:
    return {**_detent(rng), "detent_order_3": 360.0 / float(rng.choice([1.2, 1.44, 2.4]))}


def _torque_harmonic_between(rng: np.random.Generator) -> Size:
    return {**_torque_harmonic(rng), "harmonic_order": float(rng.choice([7, 9]))}


def _kinematic_error_between(rng: np.random.Generator) -> Size:
    return {**_kinematic_error(rng), "kinematic_order": float(rng.choice([3, 6]))}


def _imbalance(rng: np.random.Generator) -> Size:
    return {str(rng.choice(["r_R", "r_L", "r_k"])): signed(rng, 3e-3, 3e-2)}


def _phase_offset(rng: np.random.Generator) -> Size:
    return {"offset_A": signed(rng, 0.01, 0.1), "offset_B": signed(rng, 0.01, 0.1)}


def _kinematic_error(rng: np.random.Generator) -> Size:
    order = float(rng.choice([1, 2, 4]))
    return {"kinematic_order": order, "kinematic": log_uniform(rng, 3e-6, 5e-5), "kinematic_phase": phase(rng)}


def _output_friction(rng: np.random.Generator) -> Size:
    coulomb = log_uniform(rng, 2e-3, 2e-2)
    return {"output_coulomb": coulomb, "output_stiction": rng.uniform(0.0, 0.5) * coulomb}


def _mains(rng: np.random.Generator) -> Size:
    size = {"mains_hz": float(rng.choice([50.0, 60.0])), "mains_1": log_uniform(rng, 1e-3, 1e-2)}
    return size | {f"mains_{k}": rng.uniform(0.0, 0.5) * size["mains_1"] for k in (2, 3)}


def _gear_hysteresis(rng: np.random.Generator) -> Size:
    return {"hysteresis_stiffness": log_uniform(rng, 20.0, 200.0), "hysteresis_torque": log_uniform(rng, 3e-3, 3e-2)}


def _warming(rng: np.random.Generator) -> Size:
    return {"warming": log_uniform(rng, 0.02, 0.2), "warming_s": log_uniform(rng, 1.0, 10.0)}


def _detent_hysteresis(rng: np.random.Generator) -> Size:
    return {"lag_torque": log_uniform(rng, 5e-4, 3e-3), "lag_angle": math.radians(log_uniform(rng, 5.0, 30.0))}


def _friction_over_angle(rng: np.random.Generator) -> Size:
    period = math.radians(log_uniform(rng, 1.0, 10.0))
    return {"angle_share": log_uniform(rng, 0.05, 0.5), "angle_period": period, "angle_phase": phase(rng)}


def _cross_axis_mode(rng: np.random.Generator) -> Size:
    return {
        "cross_gain": signed(rng, 3e-3, 0.05),
        "cross_w": 2.0 * math.pi * log_uniform(rng, 100.0, 700.0),
        "cross_zeta": log_uniform(rng, 0.01, 0.05),
    }


def _anti_alias(rng: np.random.Generator) -> Size:
    return {"alias_order": float(rng.choice([2, 4])), "alias_w": 2.0 * math.pi * log_uniform(rng, 1500.0, 3000.0)}


EFFECTS: Mapping[str, Effect] = {
    "detent": Effect("third detent of 0.9 or 7.2 deg, 0.5 to 5 mN m", _detent),
    "torque_harmonic": Effect("harmonic 3 or 5 of the torque constant, 0.3 to 3 %", _torque_harmonic),
    "imbalance": Effect("R, L or k of the phases apart, half difference 0.3 to 3 %", _imbalance),
    "phase_offset": Effect("offset of each phase voltage, 10 to 100 mV", _phase_offset),
    "kinematic_error": Effect("kinematic error of order 1, 2 or 4, 3 to 50 urad at the output", _kinematic_error),
    "backlash": Effect("backlash, 1 to 10 urad at the output", lambda rng: {"backlash": log_uniform(rng, 1e-6, 1e-5)}),
    "output_friction": Effect("dry friction at the output, 2 to 20 mN m, stiction up to half above", _output_friction),
    "stribeck": Effect(
        "Stribeck friction, speed 0.5 to 4 rad/s", lambda rng: {"stribeck_rate": log_uniform(rng, 0.5, 4.0)}
    ),
    "load_dependent_friction": Effect(
        "friction that grows with the transmitted torque, 2 to 20 % of it",
        lambda rng: {"load_share": log_uniform(rng, 0.02, 0.2)},
    ),
    "charge_amplifier": Effect(
        "charge amplifier, time constant 0.3 to 5 s",
        lambda rng: {"amplifier_s": log_uniform(rng, 0.3, 5.0)},
        in_mechanism=False,
    ),
    "anti_alias": Effect("Butterworth low-pass of order 2 or 4, 1.5 to 3 kHz", _anti_alias, in_mechanism=False),
    "supply_apart": Effect(
        "supply voltage of its own in every record, standard deviation 0.3 to 2 %",
        lambda rng: {"supply": log_uniform(rng, 3e-3, 2e-2)},
        in_mechanism=False,
    ),
    "clock": Effect(
        "recorder's clock off by 20 to 500 ppm",
        lambda rng: {"clock_ppm": signed(rng, 20.0, 500.0)},
        in_mechanism=False,
    ),
    "mains_hum": Effect("mains hum, 1 to 10 mN m at 50 or 60 Hz and two multiples", _mains, in_mechanism=False),
    "quantisation": Effect(
        "resolution of 3 to 20 mN m, not declared",
        lambda rng: {"resolution": log_uniform(rng, 3e-3, 2e-2)},
        in_mechanism=False,
    ),
    "detent_between": Effect("third detent of 1.2, 1.44 or 2.4 deg, which no term has", _detent_between),
    "torque_harmonic_between": Effect(
        "harmonic 7 or 9 of the torque constant, which no term has", _torque_harmonic_between
    ),
    "kinematic_error_between": Effect("kinematic error of order 3 or 6, which no term has", _kinematic_error_between),
    "gear_hysteresis": Effect(
        "Dahl's hysteresis in the gear, 20 to 200 N m/rad, slipping at 3 to 30 mN m", _gear_hysteresis, in_library=False
    ),
    "torque_saturation": Effect(
        "torque constant that falls with the current squared, by 0.5 to 5 % at U/R",
        lambda rng: {"saturation": log_uniform(rng, 5e-3, 0.05)},
        in_library=False,
    ),
    "coil_warming": Effect(
        "coil resistance that rises by 2 to 20 % with a time constant of 1 to 10 s", _warming, in_library=False
    ),
    "inductance_over_angle": Effect(
        "coil inductance that varies over the electrical angle, by 0.1 to 1 %",
        lambda rng: {"inductance_share": signed(rng, 1e-3, 1e-2)},
        in_library=False,
    ),
    "chopper_ripple": Effect(
        "chopper ripple of 1 to 10 V at 1 to 3 kHz on the phases, in proportion to each",
        lambda rng: {"chopper": log_uniform(rng, 1.0, 10.0), "chopper_hz": log_uniform(rng, 1000.0, 3000.0)},
        in_library=False,
    ),
    "friction_over_angle": Effect(
        "dry friction that varies over the output's angle, by 5 to 50 %, period 1 to 10 deg",
        _friction_over_angle,
        in_library=False,
    ),
    "cross_axis_mode": Effect(
        "mode of the rig at 100 to 700 Hz, 0.3 to 5 % of the total torque",
        _cross_axis_mode,
        in_library=False,
        in_mechanism=False,
    ),
    "detent_hysteresis": Effect(
        "hysteresis of the detent torque, 0.5 to 3 mN m, built up over 5 to 30 deg electrical",
        _detent_hysteresis,
        in_library=False,
    ),
}
NOTHING = "nothing"
"""Effect of a complete bench."""


def effects_of(name: str, table: Mapping[str, Effect] = EFFECTS) -> list[str]:
    """Return the effects that a bench's effect stands for.

    Raises
    ------
    ValueError
        One is not of the table, or there twice.
    """
    names = [] if name == NOTHING else name.split("+")
    unknown = [one for one in names if one not in table]
    if unknown or len(set(names)) < len(names):
        raise ValueError(f"{name!r} is none of {NOTHING}, {', '.join(table)}, nor some of them joined by '+'")
    return names


def size_of(
    name: str, rng: np.random.Generator, table: Mapping[str, Effect] = EFFECTS, *, of_rig: bool = True
) -> dict[str, float]:
    """Return the size of a bench's effect, drawn; `of_rig=False` leaves away what the mechanism itself has not.

    Raises
    ------
    ValueError
        An effect is unknown, or two of them are one and the same thing at two sizes.
    """
    size: dict[str, float] = {}
    left_out: set[str] = set()
    for one in effects_of(name, table):
        further = table[one].draw(rng)
        if size.keys() & further.keys():
            raise ValueError(f"{name!r}: its effects set the same {', '.join(sorted(size.keys() & further.keys()))}")
        size |= further
        left_out |= further.keys() if not (of_rig or table[one].in_mechanism) else set()
    return {key: value for key, value in size.items() if key not in left_out}
