"""Plot of a record with the prediction of a fit and the residual."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mechid.analysis.prediction import predict
from mechid.identification.result.fit import Fit
from mechid.ink.axes import axes_or_new, draw_over_time, one_of
from mechid.ink.palette import MEASURED, MODELLED, RESIDUAL

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def plot_fit(fit: Fit, record: str | None, quantity: str | None, ax: Axes | None) -> Axes:
    """Draw measurement, prediction and residual of a record, without offset and drift."""
    campaign = fit.required_campaign
    name = one_of(record, (r.name for r in campaign.records if r.data is not None), "record")
    found = predict(campaign.record(name), fit)
    quantity = one_of(quantity, found, "quantity")
    one, axes = found[quantity], axes_or_new(ax)
    draw_over_time(axes, one.level, one.base, quantity, color=MEASURED, linewidth=1.6, label="measured")
    draw_over_time(axes, one.modelled, one.base, quantity, color=MODELLED, linewidth=0.8, label="modelled")
    draw_over_time(axes, one.residual, one.base, quantity, color=RESIDUAL, linewidth=0.6, label="residual")
    axes.legend(loc="upper right", ncols=3)
    axes.set_title(name, loc="left")
    return axes
