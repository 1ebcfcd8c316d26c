"""Number formats: standard errors with two digits, values to the same decimal."""

from __future__ import annotations

import math

SIGMA_DIGITS = 2
PLAIN_DIGITS = 6
# Longer numbers are hard to read without a power of ten.
SMALLEST, LARGEST = 1e-4, 1e7
"""Range of magnitudes shown without a power of ten."""


def with_sigma(value: float, sigma: float | None) -> tuple[str, str]:
    """Format value and standard error; without a usable error, the second text is empty.

    Examples
    --------
    >>> with_sigma(0.3841234, 0.0000852)
    ('0.384123', '0.000085')
    >>> with_sigma(913.2, 12.6)
    ('913', '13')
    >>> with_sigma(8.9123e-6, 1.23e-8)
    ('8.912e-06', '0.012e-06')
    >>> with_sigma(2.0, None)
    ('2', '')
    """
    if sigma is None or not math.isfinite(sigma) or sigma <= 0.0 or not math.isfinite(value):
        return plain(value), ""
    exponent = _exponent(max(abs(value), sigma))
    scale, suffix = 10.0**exponent, f"e{exponent:+03d}" if exponent else ""
    decimals = _decimals(sigma / scale)
    return _fixed_point(value / scale, decimals) + suffix, _fixed_point(sigma / scale, decimals) + suffix


def like(value: float, sigma: float | None) -> str:
    """Format another value, as a true one, to the decimal at which `sigma` begins."""
    return with_sigma(value, sigma)[0]


def plain(value: float | None, digits: int = PLAIN_DIGITS) -> str:
    """Format a number with some significant digits, ``-`` for None.

    Examples
    --------
    >>> plain(0.0229), plain(None), plain(8.9e-6), plain(0.002013, 2)
    ('0.0229', '-', '8.9e-06', '0.002')
    """
    return "-" if value is None or not math.isfinite(value) else f"{value:.{digits}g}"


def count_text(value: float | None) -> str:
    """Format a real-valued count, as of effective samples: below 100 with two digits, ``-`` for None.

    Examples
    --------
    >>> count_text(9931.51), count_text(4.39), count_text(None)
    ('9932', '4.4', '-')
    """
    return f"{value:.0f}" if value is not None and 100.0 <= value < LARGEST else plain(value, SIGMA_DIGITS)


def digits(value: float | None, count: int) -> str:
    """Format a number with fixed significant digits, including final zeros.

    Examples
    --------
    >>> digits(0.002, 3), digits(12.0, 3), digits(0.0, 3), digits(1234.5, 2)
    ('0.00200', '12.0', '0', '1234')
    """
    if value is None or not math.isfinite(value):
        return "-"
    if value == 0.0:
        return "0"
    if not SMALLEST / 10.0 <= abs(value) < LARGEST:
        return f"{value:.{count - 1}e}"
    return f"{value:.{max(count - 1 - math.floor(math.log10(abs(value))), 0)}f}"


def _exponent(size: float) -> int:
    """Return the power of ten to factor out, 0 for readable magnitudes."""
    return 0 if SMALLEST <= size < LARGEST else math.floor(math.log10(size))


def _decimals(sigma: float) -> int:
    """Return the decimals that show `sigma` with two digits, also if it rounds up to a power of ten."""
    rounded = float(f"{sigma:.{SIGMA_DIGITS - 1}e}")
    return SIGMA_DIGITS - 1 - math.floor(math.log10(rounded))


def _fixed_point(value: float, decimals: int) -> str:
    # A format specification cannot round to tens.
    if decimals < 0:
        value = round(value, decimals)
    text = f"{value:.{max(decimals, 0)}f}"
    # A small negative value would read as -0.0.
    return text.removeprefix("-") if float(text) == 0.0 else text
