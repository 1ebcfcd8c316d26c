"""Figures of an emission verdict: spectra with masks, waterfalls, values of requirements over the rate."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from mechid.arrays import FloatArray
from mechid.budgets.prediction_figures import RATE, draw_shares_of_limit, predicts
from mechid.emissions.emission import Emission, EmissionSpectrum
from mechid.emissions.order_figure import draw_orders
from mechid.ink.figures import BAR_IN, STYLE, WIDTH_IN, in_powers, legend_above, make_figure
from mechid.ink.palette import LIMIT, MEASURED, NOISE, series
from mechid.ink.quantities import FREQUENCY
from mechid.specification.requirement import AMPLITUDE, PSD

SPECTRUM_IN, WATERFALL_IN, OVER_RATE_IN = 2.8, 3.2, 2.6
SHOWN_DECADES = 3.5
"""Of a waterfall's amplitude."""


def spectrum_name(direction: str, kind: str = AMPLITUDE) -> str:
    """Return the name of the figure of a direction's spectrum."""
    return f"emission_{direction}_spectrum" if kind == AMPLITUDE else f"emission_{direction}_density"


def waterfall_name(direction: str) -> str:
    """Return the name of the figure of a direction's waterfall."""
    return f"emission_{direction}_waterfall"


def over_rate_name(number: int) -> str:
    """Return the name of the figure of a requirement, counted from 0, over the rate."""
    return f"emission_requirement_{number + 1}_over_rate"


def orders_name(stepping: str) -> str:
    """Return the name of the figure of the largest orders of a way of stepping."""
    return f"emission_orders_{stepping}"


def steppings_of(prediction: Mapping[str, Any] | None) -> list[str]:
    """Return the ways of stepping of a prediction that have lines; none without a prediction."""
    return list(dict.fromkeys(one["stepping"] for one in prediction["orders"])) if prediction else []


def directions_of(found: Emission) -> list[str]:
    """Return the directions that were measured, in their order."""
    return list(dict.fromkeys(one.direction for one in found.spectra))


def rates_of(at_rates: Sequence[Mapping[str, Any]]) -> list[float]:
    """Return the rates at which a requirement has a value, ascending, none twice."""
    return sorted({one["rate"] for one in at_rates if one["rate"] is not None and one["worst"] is not None})


def emission_figures(found: Emission, data: Mapping[str, Any]) -> Iterator[tuple[str, Figure]]:
    """Yield the figures of an emission verdict by name, one after the other."""
    with mpl.rc_context(STYLE), np.errstate(all="ignore"):
        for direction in directions_of(found):
            own = [one for one in found.spectra if one.direction == direction]
            masks = [one for one in data["requirements"] if _measures(one, direction, found)]
            for kind in (AMPLITUDE, PSD):
                if kind == AMPLITUDE or any(one["kind"] == PSD for one in masks):
                    drawing = partial(_spectrum, found, own, [one for one in masks if one["kind"] == kind], kind)
                    yield spectrum_name(direction, kind), make_figure(drawing, SPECTRUM_IN)
            if _one_for_each_rate(own):
                yield waterfall_name(direction), make_figure(partial(_waterfall, own), WATERFALL_IN)
        for k, requirement in enumerate(data["requirements"]):
            predicted = requirement["predicted"]
            if predicts(predicted):
                shares = partial(draw_shares_of_limit, requirement["direction"], predicted, requirement["at_rates"])
                yield over_rate_name(k), make_figure(shares, OVER_RATE_IN)
            elif len(rates_of(requirement["at_rates"])) > 1:
                yield over_rate_name(k), make_figure(partial(_over_rate, requirement), OVER_RATE_IN)
        for stepping in steppings_of(data["prediction"]):
            orders = [one for one in data["prediction"]["orders"] if one["stepping"] == stepping]
            yield orders_name(stepping), make_figure(partial(draw_orders, orders), WATERFALL_IN)


def _measures(requirement: Mapping[str, Any], direction: str, found: Emission) -> bool:
    """Tell whether a requirement applies to a direction; on the torque it does to the moment about the drive axis."""
    names = directions_of(found)
    return bool(
        requirement["direction"] == direction
        or (requirement["direction"] == "torque" and "torque" not in names and direction.startswith("m"))
    )


def _one_for_each_rate(spectra: Sequence[EmissionSpectrum]) -> list[EmissionSpectrum]:
    """Return the spectra of a waterfall, one for each rate; none where there is but one rate."""
    by_rate = {abs(one.rate): one for one in spectra if np.isfinite(one.rate)}
    return [by_rate[rate] for rate in sorted(by_rate)] if len(by_rate) > 1 else []


def envelope_of(spectra: Sequence[EmissionSpectrum], values: str = "amplitude") -> tuple[FloatArray, FloatArray]:
    """Return the frequencies of the first spectrum and the largest value of all at each."""
    frequency = spectra[0].frequency_hz
    # Stretches of other lengths have other bins.
    rows = [np.interp(frequency, one.frequency_hz, getattr(one, values)) for one in spectra]
    return frequency, np.max(rows, axis=0)


def _spectrum(
    found: Emission, own: Sequence[EmissionSpectrum], masks: Sequence[Mapping[str, Any]], kind: str, figure: Any
) -> None:
    """Draw each rate thin, the envelope over the rates, the background and the masks."""
    axes = figure.subplots()
    values = "amplitude" if kind == AMPLITUDE else "density"
    for one in own:
        axes.plot(one.frequency_hz, getattr(one, values), color=MEASURED, linewidth=0.4, alpha=0.4)
    axes.plot(*envelope_of(own, values), color=MEASURED, linewidth=1.0, label="worst case over rates")
    for one in (one for one in found.backgrounds if one.direction == own[0].direction):
        axes.plot(
            one.frequency_hz, getattr(one, values), color=NOISE, linewidth=0.8, label=f"background ({one.record})"
        )
    for k, requirement in enumerate(masks):
        frequency, limit = np.array(requirement["mask"]).T
        style = "steps-post" if requirement["interpolation"] == "step" else "default"
        axes.plot(
            frequency, limit, color=LIMIT, linestyle=("-", "--", ":")[k % 3], drawstyle=style, label=requirement["name"]
        )
    unit = own[0].unit.replace("*", " ")
    squared = {"N": "N²", "N m": "N² m²"}[unit]
    label = (
        f"{own[0].direction}: amplitude (peak), {unit}"
        if kind == AMPLITUDE
        else f"{own[0].direction}: density, {squared}/Hz"
    )
    axes.set(xlabel=FREQUENCY, ylabel=label, xscale="log", yscale="log")
    axes.set_xlim(own[0].frequency_hz[1], found.bands_hz.get(own[0].direction, found.usable_hz)[1])
    in_powers(axes.xaxis)
    in_powers(axes.yaxis)
    legend_above(figure, axes, 3)


def _waterfall(own: Sequence[EmissionSpectrum], figure: Any) -> None:
    """Draw amplitude over frequency and rate."""
    rated = _one_for_each_rate(own)
    frequency = rated[0].frequency_hz
    rows = np.stack([np.interp(frequency, one.frequency_hz, one.amplitude) for one in rated])
    figure.subplots_adjust(right=1.0 - BAR_IN / WIDTH_IN)
    axes = figure.subplots()
    # The first point is at 0 Hz, which the logarithmic axis does not show.
    high = float(rows[:, 1:].max()) or 1.0
    # the median is near the noise of the bench, below which a waterfall shows nothing
    low = max(float(np.median(rows)), high / 10.0**SHOWN_DECADES)
    image = axes.pcolormesh(
        frequency,
        [abs(one.rate) for one in rated],
        np.maximum(rows, low),
        norm=LogNorm(low, high),
        cmap="cividis",
        # As vectors, each cell would be an element of the SVG.
        rasterized=True,
        shading="nearest",
    )
    axes.set(xlabel=FREQUENCY, ylabel=RATE, xscale="log", xlim=(frequency[1], frequency[-1]))
    axes.grid(visible=False)
    in_powers(axes.xaxis)
    unit = own[0].unit.replace("*", " ")
    bar = figure.colorbar(
        image, ax=axes, label=f"{own[0].direction}: amplitude (peak), {unit}", pad=0.02, fraction=0.06
    )
    in_powers(bar.ax.yaxis)


def _over_rate(requirement: Mapping[str, Any], figure: Any) -> None:
    """Draw the value that decides at each rate with its bounds, over its limit."""
    axes = figure.subplots()
    rows = [one for one in requirement["at_rates"] if one["rate"] is not None and one["worst"] is not None]
    rows.sort(key=lambda one: float(one["rate"]))
    rate = np.array([one["rate"] for one in rows])
    value, lower, upper, limit = (
        np.array([one["worst"][key] for one in rows]) for key in ("value", "lower", "upper", "limit")
    )
    between = [np.maximum(value - lower, 0.0), np.maximum(upper - value, 0.0)]
    axes.errorbar(
        rate,
        value,
        between,
        color=series(0),
        marker="o",
        markersize=3.0,
        linewidth=0.8,
        capsize=2.0,
        label="worst value",
    )
    axes.plot(rate, limit, color=LIMIT, linestyle="--", label="limit there")
    axes.set(xlabel=RATE, ylabel=f"{requirement['direction']}, {requirement['text']['unit']}", yscale="log")
    in_powers(axes.yaxis)
    legend_above(figure, axes, 2)
