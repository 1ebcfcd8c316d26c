"""Registers of drivers. Truth: the difference rule of the data sheets, decoded here by itself, and sines."""

import numpy as np

from mechid.command.phase_table import nominal_table
from mechid.quiet_drives.driver_registers import (
    AMPLITUDE,
    encode_quarter,
    quarter_of_table,
    table_of_quarter,
)


def decode(registers):
    """Return the wave of the registers by the data sheet: a bit b in a segment of width W adds W - 1 + b."""
    select, value = registers["MSLUTSEL"], registers["MSLUTSTART"] & 0xFF
    ends = [0, *((select >> (8 * k)) & 0xFF for k in (1, 2, 3)), 256]
    wave = [value]
    for k in range(256):
        segment = max(s for s in range(4) if ends[s] <= k)
        width = (select >> (2 * segment)) & 3
        bit = (registers[f"MSLUT{k // 32}"] >> (k % 32)) & 1
        value += width - 1 + bit
        wave.append(value)
    return np.array(wave)


def test_a_sine_is_encoded_within_one_code():
    wanted = quarter_of_table(nominal_table(256))
    found = encode_quarter(wanted)
    np.testing.assert_array_equal(decode(found.registers), found.wave)
    assert np.abs(found.wave - wanted).max() < 1.0
    assert found.registers["MSLUTSTART"] == AMPLITUDE << 16


def test_the_played_table_is_the_one_that_was_encoded():
    played = table_of_quarter(quarter_of_table(nominal_table(16)) / AMPLITUDE, 16)
    np.testing.assert_allclose(played, nominal_table(16), atol=1e-12)
