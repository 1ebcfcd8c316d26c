"""Parameters of which the records say less than the mechanism file does: their error is none to print."""

from __future__ import annotations

import math

from mechid.identification.identifiability.settings import VERDICTS
from mechid.parameter import Parameter

REMEDY = "its value is where the search left it; add a record that shows it, or give it as a known number"


def not_known(parameter: Parameter, value: float, std_error: float) -> str:
    """Return why records do not know a parameter, with the remedy; empty where they do.

    A standard error above the allowed range over the root of 12, the standard deviation of a value anywhere in it, says
    less than the range did before; so does one that is not finite.

    Examples
    --------
    >>> from mechid.campaign import catalogue_mechanism
    >>> viscous = catalogue_mechanism().parameters["friction.viscous"]
    >>> not_known(viscous, 0.006, 0.001)
    ''
    >>> not_known(viscous, 0.006, 5e15).partition(";")[0]
    'not known from these records: its standard error of 5e+15 exceeds what its range of 0 to 0.05 allows'
    """
    span = parameter.max - parameter.min
    least = span / math.sqrt(12.0) if math.isfinite(span) else VERDICTS.most_relative * abs(value) or math.inf
    if std_error <= least and math.isfinite(std_error):
        return ""
    if not math.isfinite(std_error):
        return f"not known from these records: nothing limits it; {REMEDY}"
    allowed = f"its range of {parameter.min:.6g} to {parameter.max:.6g} allows"
    over = f"what {allowed}" if math.isfinite(span) else f"{VERDICTS.most_relative:g} times its value"
    return f"not known from these records: its standard error of {std_error:.3g} exceeds {over}; {REMEDY}"
