"""Rows of a validation: the prediction of each channel, and its orders."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from mechid.analysis.order_tracking import OrderError
from mechid.analysis.validation import ChannelValidation, RecordValidation
from mechid.ink.digits import count_text, digits, plain
from mechid.ink.quantities import has_only_torque, quantity_words
from mechid.units import unit_words


def validation_rows(validation: Mapping[str, RecordValidation]) -> list[dict[str, Any]]:
    """Return a row of numbers and texts for each channel of each record."""
    return _add_quantity(
        [_row(record, channel) for record in validation.values() for channel in record.channels.values()]
    )


def order_rows(validation: Mapping[str, RecordValidation]) -> list[dict[str, Any]]:
    """Return a row of numbers and texts for each order of each channel."""
    return _add_quantity(
        [
            _order_row(record, channel.quantity, order)
            for record in validation.values()
            for channel in record.channels.values()
            for order in channel.orders
        ]
    )


def _add_quantity(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Add texts of quantity and unit, empty if there is only the torque."""
    only_torque = has_only_torque(rows)
    for row in rows:
        row["text"] |= {
            "quantity": "" if only_torque else quantity_words(row["quantity"]),
            "unit": "" if only_torque else unit_words(row["quantity"]),
        }
    return rows


def _row(record: RecordValidation, channel: ChannelValidation) -> dict[str, Any]:
    row = channel.to_dict()
    theil, test = row["theil"], row["ljung_box"]
    return {
        "name": record.name,
        "use": channel.use or record.use,
        "quantity": channel.quantity,
        "fitted_of_its_own": list(record.nuisance.words()) if record.nuisance else [],
        "judged_from_s": record.nuisance.until_s if record.nuisance else None,
        **{key: entry for key, entry in row.items() if key != "orders"},
        "text": {
            "fit_percent": digits(channel.fit_percent, 4),
            "residual_rms": digits(channel.residual_rms, 3),
            "theil": digits(theil["coefficient"], 3),
            **{part: _share(theil[part]) for part in ("bias", "variance", "covariance")},
            "p_value": digits(test["p_value"], 2),
            "largest": digits(test["largest"], 2),
            "effective": count_text(channel.effective_samples),
        },
    }


def _share(part: float) -> str:
    """Format a share with three decimals, `-` for NaN.

    Examples
    --------
    >>> _share(0.98765), _share(2e-28), _share(float("nan"))
    ('0.988', '0.000', '-')
    """
    return f"{part:.3f}" if math.isfinite(part) else "-"


def _order_row(record: RecordValidation, quantity: str, order: OrderError) -> dict[str, Any]:
    return {
        "name": record.name,
        "use": record.use,
        "quantity": quantity,
        "order": order.order,
        "windows": order.windows,
        "measured": order.measured,
        "modelled": order.modelled,
        "amplitude_error_percent": order.amplitude_error_percent,
        "phase_error_deg": order.phase_error_deg,
        "peak_rate": order.peak_rate,
        "text": {
            "order": plain(order.order),
            "measured": digits(order.measured, 3),
            "modelled": digits(order.modelled, 3),
            "amplitude_error_percent": digits(order.amplitude_error_percent, 2),
            "phase_error_deg": digits(order.phase_error_deg, 2),
            "peak_rate": digits(order.peak_rate, 3),
        },
    }
