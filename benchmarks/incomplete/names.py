"""What `mechid diagnose` has to call each effect of a bench, and whether it did."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from incomplete.effects import NOTHING, Size

PLAIN = {
    "imbalance": "stepper.imbalance",
    "phase_offset": "stepper.phase_offset",
    "backlash": "gear.backlash",
    "output_friction": "output_friction",
    "stribeck": "friction.stribeck",
    "load_dependent_friction": "friction.load_dependent",
    "anti_alias": "anti_alias",
    "charge_amplifier": "charge_amplifier",
    "supply_apart": "record.voltage",
    "gain_apart": "record.gain",
    "gain_common": "record.gain",
    "trigger": "record.delay",
    "clock": "clock",
    "cross_axis_mode": "housing.second_mode",
    "inductance_over_angle": "stepper.saliency",
}
NAMELESS = (
    "detent_hysteresis",
    "quantisation",
    "gear_hysteresis",
    "torque_saturation",
    "coil_warming",
    "chopper_ripple",
)
"""What no block holds, or what is noise: nothing is to be named for it."""

EQUIVALENT = {
    "record.clock": ("clock",),
    "stepper.phase_offset": ("stepper.detent:7.2deg",),
    "stepper.detent:7.2deg": ("stepper.phase_offset",),
}
"""Further names of the same thing: one clock read record by record; an offset of the phases and the detent of one
electrical period, which at the currents of one supply are one torque."""


def name_of(effect: str, size: Size) -> str:
    """Return the name of one effect of a size; empty where it has none."""
    match effect.removesuffix("_between"):
        case "detent":
            return f"stepper.detent:{_period_text(round(size['detent_order_3']))}deg"
        case "torque_harmonic":
            return f"stepper.torque_harmonic:{size['harmonic_order']:g}"
        case "kinematic_error":
            return f"gear.kinematic_error:{size['kinematic_order']:g}"
        case "friction_over_angle":
            over = "friction.position" if size.get("angle_of_rotor") else "friction.position:output"
            return f"{over}:{2.0 * math.pi / size['angle_period']:.0f}"
        case "mains_hum":
            return f"mains:{size['mains_hz']:g}Hz"
        case other:
            return "" if other in (NOTHING, *NAMELESS) else PLAIN[other]


def _period_text(periods: int) -> str:
    """Return the degrees of a period to as many digits, three at least, as tell the number in a turn."""
    texts = (f"{360.0 / periods:.{digits}g}" for digits in range(3, 9))
    return next(text for text in texts if round(360.0 / float(text)) == periods)


def names_of(effect: str, size: Size) -> list[str]:
    """Return the names of a bench's effects, those without a name left out."""
    return [name for one in effect.split("+") if (name := name_of(one, size))]


def entries_of(line: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """Return each entry's name with its aliases, of a fit's or a diagnosis's line."""
    return [(one["name"], *one["aliases"]) for one in line["missing"]]


def is_exact(line: Mapping[str, Any]) -> bool:
    """Tell whether just the effects that are missing were named."""
    right = names_of(line["effect"], line["size"])
    return not false_names(right, entries_of(line)) and not unnamed(right, entries_of(line))


def with_equivalents(entries: Iterable[tuple[str, ...]]) -> list[tuple[str, ...]]:
    """Return entries with the names that stand for the same thing in every record, beside their aliases."""
    return [(*entry, *(other for name in entry for other in EQUIVALENT.get(name, ()))) for entry in entries]


def false_names(names: Iterable[str], entries: Sequence[tuple[str, ...]]) -> list[str]:
    """Return the first name of each entry, a name with its aliases, that holds none of the right names."""
    right = set(names)
    return [entry[0] for entry in entries if not right & set(entry)]


def unnamed(names: Iterable[str], entries: Sequence[tuple[str, ...]]) -> list[str]:
    """Return the right names that no entry holds."""
    held = {name for entry in entries for name in entry}
    return [name for name in names if name not in held]
