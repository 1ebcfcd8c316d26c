"""Table of a budget's inputs: flight values, uncertainties, model discrepancy and errors of other sources."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from mechid.budgets.texts import side_words
from mechid.ink.data import Data
from mechid.ink.table import Table
from mechid.ink.text_table import Column, OnPage

BASIS = (Column("", "name", words=True), Column("", "value", words=True, on_page=OnPage(wide=True)))
KNOWN = (
    "from the residuals of the torque records: an upper bound unless the path from the rotor to the base is the same "
    "on the bench and in flight"
)
NOT_KNOWN = "not known: there is no residual.json of a torque record"


def basis_table(data: Data) -> Table:
    """Return the inputs of a budget by name."""
    return Table(BASIS, [{"name": name, "value": value} for name, value in _pairs(data) if value])


def _pairs(data: Data) -> Iterator[tuple[str, str]]:
    flight = data["flight"]
    yield "flies in place of the bench's", _list_values(flight["values"], 6) or "nothing"
    yield (
        "uncertain, one standard deviation",
        _list_values(flight["uncertain"], 3) or "nothing beside the estimate's covariance",
    )
    yield "spreads over the ensemble", _list_values(flight["spread"], 3) or "nothing"
    yield "left on the bench", ", ".join(flight["left_on_bench"]) or "nothing"
    yield "forces and moments beside the torque", side_words(data)
    yield "what the model lacks", KNOWN if data["residual_known"] else NOT_KNOWN
    yield "the model misses on validation records", _discrepancy(data)
    for error in data["errors"]:
        yield error["name"], _error(error)


def _list_values(values: Mapping[str, float], digits: int) -> str:
    return ", ".join(f"{name} {value:.{digits}g}" for name, value in values.items())


def _discrepancy(data: Data) -> str:
    alone = " (counts for profiles alone)" if data["residual_known"] else ""
    orders = (f"order {order:g}: {100.0 * error:.2g} %" for order, error in data["model_discrepancy_by_order"])
    return "; ".join([f"{100.0 * data['model_discrepancy']:.2g} % of the torque{alone}", *orders])


def _error(error: Data) -> str:
    size = f"{error['size_rad']:.3g} ± {error['spread_rad']:.3g} rad along {', '.join(error['axes'])}"
    more = (
        f"{error['frequency_hz']:g} Hz" if error["frequency_hz"] else "",
        f"up to {error['bandwidth_hz']:g} Hz" if error["bandwidth_hz"] else "",
        f"group {error['group']}" if error["group"] else "",
    )
    return ", ".join([error["kind"], size, *filter(None, more)])
