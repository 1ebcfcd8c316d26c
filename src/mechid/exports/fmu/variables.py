"""Variables of a unit: names, value references, units and start values for both FMI versions."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from mechid.exports.handover import Handover
from mechid.plant.moving_base import ACCELERATION
from mechid.plant.plant import Plant
from mechid.plant.ports import PUSH

POINTS = 32
"""Points of the rate profile among the parameters."""
INPUT, OUTPUT, PARAMETER, TIME_OF_POINT, RATE_OF_POINT = 20, 60, 1000, 2000, 3000
"""First value references of each group, as in instance.c."""
MODES = "0 the rate profile, 1 step_index, 2 rate, 3 phase voltages"
QUANTITY_UNITS = {"angle": "rad", "rate": "rad/s", "torque": "N.m", "force": "N", "position": "m", "velocity": "m/s"}
INPUT_UNITS = {
    PUSH.name: ("N.m", "torque on the output from outside"),
    ACCELERATION.name: ("rad/s2", "angular acceleration of the base"),
}


@dataclass(frozen=True)
class Variable:
    """One variable of a unit.

    Attributes
    ----------
    name : str
    number : int
        Value reference.
    causality : {"independent", "parameter", "input", "output"}
    variability : {"continuous", "discrete", "fixed", "tunable"}
    description : str
    unit : str
        Empty if the variable has no unit.
    start : float, int or None
        None for calculated variables.
    nominal : float
        Typical magnitude; 0 if unknown.
    """

    name: str
    number: int
    causality: str
    variability: str
    description: str
    unit: str = ""
    start: float | int | None = None
    nominal: float = 0.0
    whole: bool = False


def variables_of(handover: Handover) -> tuple[Variable, ...]:
    """Return the variables of a unit, for a handover whose mechanism has its ports."""
    plant = handover.mechanism.plant
    return (*_command(), *_inputs(plant), *_parameters(handover), *_outputs(plant))


def _command() -> Iterator[Variable]:
    yield Variable("time", 0, "independent", "continuous", "command time", "s")
    yield _fixed_variable("mode", 1, f"what commands the steps: {MODES}", 0)
    yield _fixed_variable("microsteps", 2, "steps of the driver for a full step: 1 full, 2 half", 1)
    yield _fixed_variable("square", 3, "1: each phase at full voltage or none; 0: cosine", 0)
    yield _fixed_variable("points", 4, "points of the rate profile that count", 0)
    yield _fixed_variable("start_angle_deg", 5, "electrical angle held until the first step", 0.0, "deg")
    yield _fixed_variable("clock_tick_s", 6, "period of the step clock, 0 for none", 0.0, "s")
    for k in range(POINTS):
        yield _fixed_variable(f"time_s[{k + 1}]", TIME_OF_POINT + k, f"time of point {k + 1}", 0.0, "s")
    for k in range(POINTS):
        yield _fixed_variable(f"rate[{k + 1}]", RATE_OF_POINT + k, f"full steps/s at point {k + 1}", 0.0, "1/s")


def _fixed_variable(key: str, number: int, words: str, start: float, unit: str = "") -> Variable:
    """Return a parameter of the command, an integer if its start value is one."""
    whole = isinstance(start, int)
    return Variable(f"command.{key}", number, "parameter", "fixed", words, unit, start, whole=whole)


def _inputs(plant: Plant) -> Iterator[Variable]:
    yield Variable(
        "step_index",
        10,
        "input",
        "discrete",
        "steps of the driver since 0, where command.mode is 1",
        start=0,
        whole=True,
    )
    yield Variable("rate", 11, "input", "discrete", "full steps/s, where command.mode is 2", "1/s", 0.0)
    for number, phase in ((12, "a"), (13, "b")):
        yield Variable(
            f"voltage_phase_{phase}",
            number,
            "input",
            "discrete",
            f"voltage (or current) of phase {phase}, where command.mode is 3",
            "",
            0.0,
        )
    if ACCELERATION in plant.inputs:
        yield Variable(
            "base_angle", 14, "input", "continuous", "angle of the base, for the angles in inertial space", "rad", 0.0
        )
        yield Variable("base_rate", 15, "input", "continuous", "rate of the base", "rad/s", 0.0)
    for k, symbol in enumerate(plant.inputs):
        if symbol.name in INPUT_UNITS:
            unit, words = INPUT_UNITS[symbol.name]
            yield Variable(
                symbol.name, INPUT + k, "input", "discrete", f"{words}; it holds until it is set again", unit, 0.0
            )


def _parameters(handover: Handover) -> Iterator[Variable]:
    own = handover.mechanism
    for k, (name, declared) in enumerate(own.plant.declarations.items()):
        # A tied parameter follows its master and cannot be set.
        if own.parameters[name].tied_to:
            continue
        value, error = own.value(name), handover.std_error(name)
        sure = "known" if error is None else f"standard error {error:.6g}"
        yield Variable(
            name,
            PARAMETER + k,
            "parameter",
            "tunable",
            f"{declared.meaning}; {sure}",
            _unit(declared.unit),
            value,
            abs(value),
        )


def _outputs(plant: Plant) -> Iterator[Variable]:
    for k, quantity in enumerate(plant.outputs):
        yield Variable(quantity, OUTPUT + k, "output", "continuous", _meaning(quantity), _of_quantity(quantity))
    if ACCELERATION in plant.inputs and {"output_angle", "output_rate"} <= plant.outputs.keys():
        yield Variable("output_angle_inertial", 90, "output", "continuous", "output angle plus that of the base", "rad")
        yield Variable("output_rate_inertial", 91, "output", "continuous", "output rate plus that of the base", "rad/s")
    if plant.switches:
        modes = ", ".join(f"{k} {mode}" for k, mode in enumerate(plant.switches[0].modes))
        yield Variable("friction_mode", 92, "output", "discrete", f"{plant.switches[0].name}: {modes}", whole=True)
    yield Variable("steps", 93, "output", "discrete", "steps of the driver so far", whole=True)


def _meaning(quantity: str) -> str:
    if quantity == "torque":
        return "torque of the mechanism on what it stands on"
    return quantity.replace("_", " ")


def _of_quantity(quantity: str) -> str:
    if quantity.startswith("current"):
        return "A"
    if quantity.startswith("voltage"):
        return "V"
    return QUANTITY_UNITS.get(quantity.rpartition("_")[2], "")


def _unit(unit: str) -> str:
    """Return a unit in FMI notation, with a full stop between factors; empty for dimensionless numbers."""
    return "" if unit == "1" else unit.replace("*", ".").replace(" ", ".").replace("^", "")
