"""Equations of a mechanism as text, and the kernel source generated from them."""

from __future__ import annotations

from mechid.errors import UsageError
from mechid.kernel.equation_text import equations_latex, equations_text
from mechid.kernel.source import generate, lanes_for
from mechid.plant.mechanism import Mechanism


def equations(mechanism: Mechanism, *, latex: bool = False) -> str:
    """Return the equations of a mechanism as they are computed: terms, rates, switches, outputs.

    Parameters
    ----------
    mechanism : Mechanism
        Only its structure matters, not its values.
    latex : bool
        Return one ``align*`` per section (package amsmath), for a report; else plain text, one equation per line,
        followed by symbol, unit and meaning of each parameter.

    Examples
    --------
    >>> import mechid
    >>> drive = mechid.make_mechanism(
    ...     {
    ...         "assembly": "direct_torque_drive",
    ...         "load": {"inertia": 0.1},
    ...         "friction": {"static": 0.02, "coulomb": 0.02, "viscous": 0.001},
    ...     }
    ... )
    >>> [line.strip() for line in mechid.equations(drive).splitlines() if "omega/dt" in line]
    ['domega/dt       = T_res/J_rot']
    """
    return equations_latex(mechanism.plant) if latex else equations_text(mechanism.plant)


def kernel_source(mechanism: Mechanism, *, sensitivities: int = 0) -> str:
    """Return the Python source generated from a mechanism's equations, which Numba compiles for simulation.

    Parameters
    ----------
    mechanism : Mechanism
        Only its structure matters; its values are arguments of the code.
    sensitivities : int
        Number of parameters whose derivatives are computed along.

    Returns
    -------
    str
        A module with the functions ``begin`` and ``run``; its docstring lists states and parameters in order.

    Raises
    ------
    UsageError
        The number of sensitivities is negative.

    Examples
    --------
    >>> import mechid
    >>> mechid.kernel_source(mechid.catalogue_mechanism()).splitlines()[0]
    '\"\"\"Kernel of stepper_gear_mass with 20 lanes. Made by mechid; do not edit.'
    """
    if sensitivities < 0:
        raise UsageError(f"sensitivities: {sensitivities} is negative; give a number of parameters, or 0")
    return generate(mechanism.plant, lanes_for(sensitivities))
