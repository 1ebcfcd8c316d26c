"""Units in the headers of columns. Truth: what each header says, by hand."""

import pytest

from mechid.units import split_header, unit_within

HEADERS = [
    ("torque_Nm", "torque", "Nm"),
    ("torque_mN_m", "torque", "mN*m"),
    ("torque_raw_Nm", "torque_raw", "Nm"),
    ("Mz [N*m]", "Mz", "N*m"),
    ("Mz (mNm)", "Mz", "mNm"),
    ("Mz_[Nm]", "Mz", "Nm"),
    ("Torque [Nm] CH1", "Torque CH1", "Nm"),
    ("Mz(CH1) [Nm]", "Mz(CH1)", "Nm"),
    ("Mz [foo]", "Mz", "foo"),
    ("time_s", "time", "s"),
    ("t/s", "t", "s"),
    ("M / Nm", "M", "Nm"),
    ("v/(m/s)", "v", "m/s"),
    ("omega_rad_s", "omega", "rad/s"),
    ("omega_rad_per_s", "omega", "rad/s"),
    ("omega_deg/s", "omega", "deg/s"),
    ("iA", "iA", None),
    ("Mz []", "Mz", None),
    ("phase_a", "phase_a", None),
    ("torque_raw", "torque_raw", None),
    ("dz/dt", "dz/dt", None),
    ("s", "s", None),
    ("", "", None),
]


@pytest.mark.parametrize(("column", "name", "unit"), HEADERS)
def test_a_header_is_split_into_name_and_unit(column, name, unit):
    assert split_header(column) == (name, unit)


UNITS_WITHIN = [
    ("torque_mNm_filtered", "torque", "mNm"),
    ("torque_oz_in", "torque", "oz in"),
    ("Torque kg cm", "torque", "kg cm"),
    ("torque µNm raw", "torque", "µNm"),
    ("Winkel grad", "rotor_angle", "grad"),
    ("deg", "output_angle", "deg"),
    ("speed in RPM", "rotor_rate", "RPM"),
    ("i mA ch1", "current_phase_a", "mA"),
    ("torque filtered", "torque", None),
    ("u_A", "voltage_phase_a", None),
    ("phase_a", "current_phase_a", None),
]


@pytest.mark.parametrize(("column", "quantity", "word"), UNITS_WITHIN)
def test_a_unit_within_a_name_is_seen(column, quantity, word):
    assert unit_within(column, quantity) == word
