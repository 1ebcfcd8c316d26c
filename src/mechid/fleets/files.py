"""Text files of a fleet: all results in fleet.json, one row per parameter and campaign in fleet.csv."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping
from typing import Any

from mechid.identification.result.estimate_file import json_text

JSON_NAME, TABLE_NAME = "fleet.json", "fleet.csv"
OF_CAMPAIGN = ("campaign", "unit", "group", "state", "grade")
OF_VALUE = ("parameter", "value", "std_error", "value_unit", "status", "left_out", "near_threshold", "off_in_spreads")
OF_FLEET = ("fleet_mean", "fleet_mean_std_error", "fleet_spread", "differs", "outlier")


def fleet_files(data: Mapping[str, Any]) -> dict[str, str]:
    """Return the contents of fleet.csv and fleet.json from the data of `fleet_data`."""
    return {TABLE_NAME: _table(data), JSON_NAME: json_text(data)}


def _table(data: Mapping[str, Any]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow((*OF_CAMPAIGN, *data["covariates"], *OF_VALUE, *OF_FLEET))
    writer.writerows(_rows(data))
    return text.getvalue()


def _rows(data: Mapping[str, Any]) -> Iterator[tuple[Any, ...]]:
    """Yield one row per value, by campaign."""
    for k, c in enumerate(data["campaigns"]):
        own = (c["label"], c["unit"], c["group"], c["state"], c["grade"])
        covariates = (c["covariates"].get(name, "") for name in data["covariates"])
        first = (*own, *covariates)
        for p in data["parameters"]:
            v = p["values"][k]
            if v is not None:
                value = (p["name"], _number(v["value"]), _number(v["std_error"]), p["unit"], v["status"], v["left_out"])
                marks = (int(v["near_threshold"]), _number(v["off"]))
                stands_off = int(any(one["unit"] == c["unit"] for one in p["outliers"]))
                fleet = (_number(p["mean"]), _number(p["std_error"]), _number(p["spread"]))
                yield (*first, *value, *marks, *fleet, int(p["differs"]), stands_off)


def _number(value: float | None) -> str:
    """Return a number as text, empty for None."""
    return "" if value is None else f"{value:.10g}"
