"""Effects whose sizes hardware fixes: each with its range, and the part or data sheet that gives the range.

The mechanisms are those of `effects.EFFECTS`. Rates of the test runs are drawn about the mechanism's resonance, as a
test engineer chooses them after a first tap test.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from incomplete.effects import Effect, Size, log_uniform, phase, signed
from incomplete.recording import Run, full_steps, resonance_hz
from mechid.plant.mechanism import Mechanism

SUPPLY_V = 5.7
"""Of the mechanism that all benches draw from."""
OWN_ORDERS = (100, 200)
"""Detents of 3.6 and 1.8 deg, which the mechanism file has."""
SWEEP_S = 20.0


def _phase_offset(rng: np.random.Generator) -> Size:
    return {f"offset_{name}": SUPPLY_V * signed(rng, 5e-3, 0.03) for name in "AB"}


def _imbalance(rng: np.random.Generator) -> Size:
    return {str(rng.choice(["r_R", "r_L", "r_k"])): 0.5 * signed(rng, 0.02, 0.05)}


def _torque_harmonic(rng: np.random.Generator, orders: tuple[int, ...]) -> Size:
    return {
        "harmonic_order": float(rng.choice(orders)),
        "harmonic": log_uniform(rng, 0.01, 0.06),
        "harmonic_phase": phase(rng),
    }


def _detent(rng: np.random.Generator, orders: list[int]) -> Size:
    return {
        "detent_order_3": float(rng.choice(orders)),
        "detent_3": log_uniform(rng, 1e-3, 6e-3),
        "detent_phase_3": phase(rng),
    }


def _kinematic_error(rng: np.random.Generator) -> Size:
    return {
        "kinematic_order": float(rng.integers(1, 9)),
        "kinematic": log_uniform(rng, 3e-5, 2e-4),
        "kinematic_phase": phase(rng),
    }


def _output_friction(rng: np.random.Generator) -> Size:
    coulomb = log_uniform(rng, 4e-3, 2e-2)
    return {"output_coulomb": coulomb, "output_stiction": rng.uniform(0.0, 0.5) * coulomb}


def _friction_over_angle(rng: np.random.Generator) -> Size:
    of_rotor = bool(rng.integers(2))
    turn = 2.0 * math.pi
    return {
        "angle_share": rng.uniform(0.1, 0.3),
        "angle_period": turn / float(rng.integers(1, 5) if of_rotor else rng.integers(24, 65)),
        "angle_phase": phase(rng),
        "angle_of_rotor": float(of_rotor),
    }


def _mains_hum(rng: np.random.Generator) -> Size:
    size = {"mains_hz": float(rng.choice([50.0, 60.0])), "mains_1": log_uniform(rng, 2e-3, 6e-3)}
    return size | {f"mains_{k}": rng.uniform(0.0, 0.5) * size["mains_1"] for k in (2, 3)}


def _anti_alias(rng: np.random.Generator) -> Size:
    return {"alias_order": float(rng.choice([2, 4])), "alias_w": 2.0 * math.pi * log_uniform(rng, 1200.0, 2500.0)}


OF_POLES = [order for order in range(50, 401, 50) if order not in OWN_ORDERS]
BETWEEN = [order for order in range(1, 401) if order % 50]
HARDWARE: Mapping[str, Effect] = {
    "phase_offset": Effect(
        "offset of each phase voltage, 0.5 to 3 % of the supply",
        _phase_offset,
        reason="linear amplifiers and digital-to-analogue converters of a microstep driver: 30 to 170 mV",
    ),
    "imbalance": Effect(
        "R, L or k of the phases apart by 2 to 5 %",
        _imbalance,
        reason="winding tolerance: data sheets give 10 % for R and 20 % for L, phases of one motor are nearer",
    ),
    "gain_apart": Effect(
        "gain of its own in every record, within 1 to 3 %",
        lambda rng: {"gain": log_uniform(rng, 0.01, 0.03)},
        in_mechanism=False,
        reason="range switches of a charge amplifier, each calibrated to 1 to 3 %",
    ),
    "gain_common": Effect(
        "gain of all records off by 1 to 3 %",
        lambda rng: {"gain_common": signed(rng, 0.01, 0.03)},
        in_mechanism=False,
        reason="sensitivity of a piezoelectric transducer under another preload than at its calibration",
    ),
    "torque_harmonic": Effect(
        "harmonic 3 or 5 of the torque constant, 1 to 6 %",
        lambda rng: _torque_harmonic(rng, (3, 5)),
        reason="flux of a hybrid stepper's teeth: third and fifth harmonics of 1 to 6 % of the back-EMF",
    ),
    "torque_harmonic_between": Effect(
        "harmonic 2, 4, 7 or 9 of the torque constant, 1 to 6 %",
        lambda rng: _torque_harmonic(rng, (2, 4, 7, 9)),
        reason="unequal rotor halves (even orders) and tooth slots (7, 9)",
    ),
    "detent": Effect(
        "third detent, a multiple of the 50 pole pairs up to 400 per rotor turn, 1 to 6 mN m",
        lambda rng: _detent(rng, OF_POLES),
        reason="teeth of stator and rotor: detent torques of 2 to 10 % of the holding torque",
    ),
    "detent_between": Effect(
        "position-dependent torque of another whole number of periods, 1 to 400 per rotor turn, 1 to 6 mN m",
        lambda rng: _detent(rng, BETWEEN),
        reason="eccentric rotor, bearing balls, teeth of the first gear stage, unequal stator poles",
    ),
    "kinematic_error": Effect(
        "kinematic error of order 1 to 8 per rotor turn, 30 to 200 urad at the output",
        _kinematic_error,
        reason="harmonic drives and precision spur gears: 10 to 40 arcsec at the output, wave generator of 2 lobes",
    ),
    "stribeck": Effect(
        "Stribeck friction, speed 1 to 4 rad/s",
        lambda rng: {"stribeck_rate": log_uniform(rng, 1.0, 4.0)},
        reason="grease film of a small ball bearing: forms at 10 to 40 rpm",
    ),
    "backlash": Effect(
        "backlash, 0.1 to 0.4 mrad at the output",
        lambda rng: {"backlash": log_uniform(rng, 1e-4, 4e-4)},
        reason="anti-backlash gears after wear, planetary gears of low backlash: 0.3 to 1.4 arcmin",
    ),
    "output_friction": Effect(
        "dry friction at the output, 4 to 20 mN m, stiction up to half above",
        _output_friction,
        reason="preloaded pair of output bearings, lip of a labyrinth, cable harness",
    ),
    "load_dependent_friction": Effect(
        "friction that grows with the transmitted torque, 5 to 20 % of it",
        lambda rng: {"load_share": log_uniform(rng, 0.05, 0.2)},
        reason="efficiency of a planetary gear or harmonic drive: 80 to 95 %",
    ),
    "friction_over_angle": Effect(
        "dry friction that varies by 10 to 30 %, 1 to 4 times a turn of the rotor or 24 to 64 times one of the output",
        _friction_over_angle,
        reason="runout of the motor's bearings; balls of the output bearing",
    ),
    "anti_alias": Effect(
        "Butterworth low-pass of order 2 or 4, 1.2 to 2.5 kHz",
        _anti_alias,
        in_mechanism=False,
        reason="anti-alias filter of a 10 kHz recorder: a quarter to an eighth of the sampling rate",
    ),
    "charge_amplifier": Effect(
        "charge amplifier, time constant 0.3 to 0.8 s",
        lambda rng: {"amplifier_s": log_uniform(rng, 0.3, 0.8)},
        in_mechanism=False,
        reason="piezoelectric transducer at the amplifier's shortest time constants",
    ),
    "mains_hum": Effect(
        "mains hum, 2 to 6 mN m at 50 or 60 Hz and two multiples",
        _mains_hum,
        in_mechanism=False,
        reason="cable of a piezoelectric transducer beside the driver's supply",
    ),
    "clock": Effect(
        "recorder's clock off by 50 to 200 ppm",
        lambda rng: {"clock_ppm": signed(rng, 50.0, 200.0)},
        in_mechanism=False,
        reason="two clocks without a common reference: quartz to 100 ppm each",
    ),
    "trigger": Effect(
        "trigger of its own in every record, up to 0.2 to 1 ms before the command",
        lambda rng: {"trigger_s": log_uniform(rng, 2e-4, 1e-3)},
        in_mechanism=False,
        reason="command and recorder started by one program: a bus cycle of 1 ms at most",
    ),
    "supply_apart": Effect(
        "supply voltage of its own in every record, standard deviation 0.3 to 2 %",
        lambda rng: {"supply": log_uniform(rng, 3e-3, 2e-2)},
        in_mechanism=False,
        reason="laboratory supply set anew for each test; voltage over the harness",
    ),
    "quantisation": Effect(
        "resolution of 2 to 10 mN m, not declared",
        lambda rng: {"resolution": log_uniform(rng, 2e-3, 1e-2)},
        in_mechanism=False,
        reason="12 bits over a transducer's range of 4 to 20 N m either way",
    ),
}
PAIRS = (
    "detent+mains_hum",
    "phase_offset+imbalance",
    "phase_offset+gain_apart",
    "torque_harmonic+supply_apart",
    "detent_between+kinematic_error",
    "kinematic_error+clock",
    "output_friction+detent",
    "stribeck+kinematic_error",
    "backlash+mains_hum",
    "load_dependent_friction+torque_harmonic",
    "charge_amplifier+trigger",
    "anti_alias+imbalance",
)
"""Two effects at once that one bench plausibly has: of the same part, or one of the mechanism and one of the rig."""


def runs_at_resonance(mechanism: Mechanism, rng: np.random.Generator) -> dict[str, Run]:
    """Draw the test runs: full steps, half steps and microsteps about the resonance and its subharmonics, a sweep.

    Every record starts at rest. One record is of microsteps at the resonance's double or of half steps at its half.
    """
    resonance = resonance_hz(mechanism)

    def near(share: float, spread: float) -> float:
        return round(share * rng.uniform(1.0 - spread, 1.0 + spread) * resonance, 1)

    micro: dict[str, Any] = {"stepping": "micro", "microsteps": 16}
    full = {
        "full_res": Run(full_steps(near(1.0, 0.08)), 1.0),
        "full_sub": Run(full_steps(near(1.0 / float(rng.choice([2, 3])), 0.04)), 1.0),
        "full_slow": Run(full_steps(round(rng.uniform(4.0, 8.0), 1)), 1.5),
    }
    double, half = near(2.0, 0.03), near(0.5, 0.1)
    other = (
        {"micro_double": Run({**micro, "rate": double}, 1.0)}
        if rng.integers(2)
        else {"half_sub": Run({**full_steps(half), "stepping": "half"}, 1.0)}
    )
    end = near(2.4, 0.05)
    return {
        **full,
        "micro_res": Run({**micro, "rate": near(1.0, 0.05)}, 1.0),
        **other,
        "sweep": Run({**micro, "rate_profile": [[0.0, 0.0], [SWEEP_S, end]]}, SWEEP_S),
    }
