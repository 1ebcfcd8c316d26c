"""Unit conversion at the file boundary: values are converted to SI once, and the rest of mechid uses SI only."""

from mechid.units.angle import angle_difference
from mechid.units.conversion import conversion_factor, is_unit, measures, time_power, to_si_factor
from mechid.units.headers import split_header, unit_within
from mechid.units.quantities import SI_UNIT, si_unit, unit_words

__all__ = [
    "SI_UNIT",
    "angle_difference",
    "conversion_factor",
    "is_unit",
    "measures",
    "si_unit",
    "split_header",
    "time_power",
    "to_si_factor",
    "unit_within",
    "unit_words",
]
