"""Names of the benchmark: campaigns, estimated parameters with their units, orders of the emission lines."""

FORMAT = "mechid-benchmark-submission/1"
CAMPAIGNS = tuple(f"{number:02d}" for number in range(1, 11))
UNITS = {
    "stepper.coil_resistance": "ohm",
    "stepper.coil_inductance": "H",
    "stepper.torque_constant": "N*m/A",
    "stepper.detent.0.amplitude": "N*m",
    "stepper.detent.0.phase_deg": "deg",
    "stepper.detent.1.amplitude": "N*m",
    "stepper.detent.1.phase_deg": "deg",
    "friction.static": "N*m",
    "friction.coulomb": "N*m",
    "friction.viscous": "N*m*s/rad",
    "gear.stiffness": "N*m/rad",
    "gear.damping": "N*m*s/rad",
    "housing.gain": "1",
    "housing.frequency": "rad/s",
    "housing.damping": "1",
}
"""Parameters that every campaign asks for, by dotted name."""
HELD_OUT = ("full_between", "half_low", "micro_double")
"""Held-out runs that every campaign asks for: no record of them exists."""
ORDERS = (0.5, 1.0, 1.5, 2.0, 3.0, 4.0)
"""Emission lines of a held-out run: multiples of its rate of full steps."""
LEVEL = 0.95
"""Level of the stated intervals."""


def is_angle(name: str) -> bool:
    """Return whether a parameter is an angle in degrees, compared on the circle."""
    return name.endswith("_deg")
