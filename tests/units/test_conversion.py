"""Factors to SI. Truth: the definition of each unit; what is no unit of the quantity is refused."""

import math
import subprocess
import sys

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mechid.errors import RecordError
from mechid.units import SI_UNIT, conversion_factor, is_unit, si_unit, to_si_factor

POUND_FORCE, INCH = 0.45359237 * 9.80665, 0.0254  # by definition

FACTORS = [
    *[(unit, "torque", 1.0) for unit in ("N*m", "Nm", "N m", "N.m", "N·m", "N-m", " N * m ", "J")],
    *[(unit, "torque", 1e-3) for unit in ("mNm", "mN*m", "mN m", "mN.m", "Nmm", "N*mm")],
    *[(unit, "torque", 1e-6) for unit in ("uNm", "µNm", "uN*m")],
    ("Ncm", "torque", 1e-2),
    ("kNm", "torque", 1e3),
    ("lbf*in", "torque", POUND_FORCE * INCH),
    ("ozf-in", "torque", POUND_FORCE / 16.0 * INCH),
    *[(unit, "torque", 1.0) for unit in ("N⋅m", "N∙m", "N×m", "(N m)", "Newton-Meter", "newtonmeter")],
    *[
        (unit, "torque", POUND_FORCE / 16.0 * INCH)
        for unit in ("oz-in", "oz in", "oz·in", "in-oz", "ozin", "OZ-IN", "ozf in", "inch-ounces")
    ],
    *[
        (unit, "torque", POUND_FORCE * INCH)
        for unit in ("in lb", "in-lb", "in.-lbs", "lb-in", "lb·in", "inlb", "LB-IN", "inch-pounds")
    ],
    *[(unit, "torque", 12.0 * POUND_FORCE * INCH) for unit in ("ft lb", "ft-lbs", "FT-LBS", "foot-pounds")],
    *[(unit, "torque", 0.0980665) for unit in ("kg cm", "kg-cm", "kgcm", "kgf·cm", "kp cm")],
    *[(unit, "torque", 9.80665e-5) for unit in ("g cm", "gcm", "gf·cm")],
    ("mN", "force", 1e-3),
    *[(unit, "force", 9.80665) for unit in ("kgf", "kp", "kg")],
    *[(unit, "force", POUND_FORCE) for unit in ("lbf", "lb", "lbs")],
    *[(unit, "rotor_angle", math.pi / 180.0) for unit in ("Grad", "DEG", "degrees")],
    ("gon", "rotor_angle", math.pi / 200.0),
    *[(unit, "rotor_angle", 2.0 * math.pi) for unit in ("rev", "turns", "U", "Umdrehungen")],
    ("rad", "rotor_angle", 1.0),
    *[(unit, "output_angle", math.pi / 180.0) for unit in ("deg", "°", "degree")],
    ("arcsec", "output_angle", math.pi / 648000.0),
    ("mrad", "rotor_angle", 1e-3),
    ("rad/s", "rotor_rate", 1.0),
    ("rad s^-1", "rotor_rate", 1.0),
    ("deg/s", "output_rate", math.pi / 180.0),
    *[
        (unit, "rotor_rate", math.pi / 30.0)
        for unit in ("rpm", "RPM", "U/min", "1/min", "min-1", "min⁻¹", "r/min", "tr/min", "Umdrehungen/min")
    ],
    *[(unit, "rotor_rate", math.pi / 180.0) for unit in ("°/s", "Grad/s", "degrees per second")],
    ("rad·s⁻¹", "rotor_rate", 1.0),
    ("rev/s", "rotor_rate", 2.0 * math.pi),
    ("mm", "position", 1e-3),
    ("mm/s", "velocity", 1e-3),
    ("A", "current_phase_a", 1.0),
    ("mA", "current_phase_b", 1e-3),
    ("V", "voltage_phase_a", 1.0),
    ("mV", "voltage_phase_b", 1e-3),
    ("s", "time", 1.0),
    ("ms", "time", 1e-3),
    *[(unit, "time", 1e-3) for unit in ("msec", "Millisekunden")],
    *[(unit, "time", 1.0) for unit in ("sec", "SEC", "Sekunden")],
    *[(unit, "time", 1e-6) for unit in ("us", "µs", "μs")],
    ("days", "time", 86400.0),
]


@pytest.mark.parametrize(("unit", "quantity", "factor"), FACTORS)
def test_a_factor_is_the_units_definition(unit, quantity, factor):
    assert to_si_factor(unit, quantity) == pytest.approx(factor, rel=1e-14)


@pytest.mark.parametrize("quantity", SI_UNIT)
def test_the_si_unit_of_a_quantity_has_factor_one(quantity):
    assert to_si_factor(si_unit(quantity), quantity) == 1.0


MEGA = '"M" means mega, which no record uses; if milli is meant, write '
GRAD = 'it may be degrees or gon (0.9 deg); write unit = "deg" or unit = "gon"'

REFUSED = [
    *[(unit, "rotor_angle", f'unknown unit "{unit}" for rotor_angle; {GRAD}') for unit in ("grad", "GRAD")],
    ("grad/s", "rotor_rate", f'unknown unit "grad/s" for rotor_rate; {GRAD}'),
    ("Ms", "time", f'unknown unit "Ms" for time; {MEGA}"ms"'),
    ("MNm", "torque", f'unknown unit "MNm" for torque; {MEGA}"mNm"'),
    ("Mrad", "output_angle", f'unknown unit "Mrad" for output_angle; {MEGA}"mrad"'),
    ("MA", "current_phase_a", f'unknown unit "MA" for current_phase_a; {MEGA}"mA"'),
    ("MV", "voltage_phase_a", f'unknown unit "MV" for voltage_phase_a; {MEGA}"mV"'),
    *[(unit, "time", f'unknown unit "{unit}" for time; expected s or a multiple of it') for unit in ("ks", "Gs", "S")],
    ("1/s", "rotor_rate", 'unit "1/s" does not measure rotor_rate; expected rad/s or a multiple of it'),
    ("g", "force", 'unit "g" does not measure force; expected N or a multiple of it'),
    ("V", "torque", 'unit "V" does not measure torque; expected N*m or a multiple of it'),
    ("N", "torque", 'unit "N" does not measure torque; expected N*m or a multiple of it'),
    ("Nm/rad", "torque", 'unit "Nm/rad" does not measure torque; expected N*m or a multiple of it'),
    ("Hz", "rotor_rate", 'unit "Hz" does not measure rotor_rate; expected rad/s or a multiple of it'),
    ("1", "rotor_angle", 'unit "1" does not measure rotor_angle; expected rad or a multiple of it'),
    ("NM", "torque", 'unknown unit "NM" for torque; expected N*m or a multiple of it'),
    ("%", "rotor_angle", 'unknown unit "%" for rotor_angle; expected rad or a multiple of it'),
    ("5 N", "force", 'unknown unit "5 N" for force; expected N or a multiple of it'),
    ("", "time", 'unknown unit "" for time; expected s or a multiple of it'),
    ("m^9^9^9^9", "position", 'unknown unit "m^9^9^9^9" for position; expected m or a multiple of it'),
]


@pytest.mark.parametrize(("unit", "quantity", "message"), REFUSED)
def test_a_wrong_unit_is_refused_with_what_is_expected(unit, quantity, message):
    with pytest.raises(RecordError) as caught:
        to_si_factor(unit, quantity)
    assert str(caught.value) == message


def test_an_unknown_quantity_is_refused_with_the_nearest():
    with pytest.raises(RecordError, match=r'unknown quantity "torqe"; did you mean "torque"\?'):
        to_si_factor("Nm", "torqe")


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.text(alphabet="Nmsrad/*^.-() 019kµ°%_", max_size=12))
def test_any_text_is_a_positive_factor_or_refused(unit):
    try:
        assert to_si_factor(unit, "torque") > 0.0
    except RecordError as error:
        assert "torque" in str(error)  # noqa: PT017


def test_pint_is_not_loaded_for_units_that_are_si_already():
    """Truth: the list of loaded modules, in a fresh interpreter."""
    program = (
        "import sys; from mechid.units import to_si_factor, split_header; "
        "to_si_factor('Nm', 'torque'); split_header('time_s'); sys.exit('pint' in sys.modules)"
    )
    subprocess.run([sys.executable, "-c", program], check=True)


@pytest.mark.parametrize(
    ("spelled", "quantity", "factor"),
    [
        ("Volts", "voltage_phase_a", 1.0),
        ("Amps", "current_phase_a", 1.0),
        ("Newton-meters", "torque", 1.0),
        ("in-lbs", "torque", 0.0254 * 4.4482216152605),
        ("foot-pounds", "torque", 0.3048 * 4.4482216152605),
        ("Degrees", "rotor_angle", 0.017453292519943295),
    ],
)
def test_units_in_words_are_those_of_the_sign(spelled, quantity, factor):
    """Truth: the international foot and pound; force by standard gravity."""
    assert to_si_factor(spelled, quantity) == pytest.approx(factor, rel=1e-12)


@pytest.mark.parametrize(
    ("unit", "to", "factor"),
    [("urad/Nm", "rad/(N*m)", 1e-6), ("kHz", "Hz", 1e3), ("°/Nm", "rad/(N*m)", math.pi / 180.0)],
)
def test_a_torque_written_together_is_one_factor_below_a_slash(unit, to, factor):
    assert conversion_factor(unit, to) == pytest.approx(factor, rel=1e-14)


def test_a_unit_with_two_meanings_is_a_unit():
    """Truth: a line of units that holds one is still a line of units, to be asked about."""
    assert is_unit("grad")
    assert not is_unit("torque")
