"""Document of a validation: prediction of each record, and its lines at orders of the step rate."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mechid.identification.result.estimate_file import json_text
from mechid.ink.document import Document, Rows
from mechid.ink.presenter import Presenter
from mechid.validations.numbers import order_rows, validation_rows
from mechid.validations.tables import order_table, validation_table


def validation_document(data: Mapping[str, Any]) -> Document:
    """Make the document from the rows of a validation."""
    parts = (Rows(validation_table(data["validation"])), Rows(order_table(data["orders"])))
    return Document(title="Prediction of the records", command="mechid validate", parts=parts)


def _texts(found: Mapping[str, Any], _data: Mapping[str, Any]) -> dict[str, str]:
    return {"validation.json": json_text({name: one.to_dict() for name, one in found.items()})}


PRESENTER = Presenter(
    name="",
    numbers=lambda found: {"validation": validation_rows(found), "orders": order_rows(found)},
    document=validation_document,
    line=", ".join,
    texts=_texts,
)
