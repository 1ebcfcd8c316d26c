"""What mechid itself has written and reads again: estimates, diagnoses, journals."""

import json
import shutil
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from fuzz.draw import Draw
from fuzz.kinds.tomls import SEEDS, TOMLS
from fuzz.tree import changed, damaged, plain
from fuzz.trial import Kind, Misread


def write_estimate(draw: Draw, folder: Path) -> dict[str, Any]:
    """Write an estimate beside the campaign that it is of."""
    for name in ("campaign.toml", "mechanism.toml", "full_46.csv", "micro_46.csv"):
        shutil.copy(SEEDS / name, folder / name)
    tree = changed(draw, json.loads((SEEDS / "estimate.json").read_text()))
    text = json.dumps(tree, default=str)
    (folder / "estimate.json").write_bytes(damaged(draw, text, 0.05))
    return {"asked": draw.choice(("estimate", "unit", "fit", "fit"))}


def read_estimate(folder: Path, written: dict[str, Any]) -> None:
    """Read it as a table, as a member of a fleet, or as a fit, and write that again."""
    from mechid.campaign import load_campaign
    from mechid.fleets.estimates import estimate_of
    from mechid.identification.result.estimate_file import estimate_text, read_estimate
    from mechid.identification.result.fit_file import read_fit, read_numbers

    path = folder / "estimate.json"
    if written["asked"] == "estimate":
        read_estimate(path)
    elif written["asked"] == "unit":
        estimate_of(read_numbers(folder))
    else:
        fit = read_fit(path, load_campaign(folder))
        text = estimate_text(fit)
        told = json.loads(path.read_bytes())["parameters"]
        again = json.loads(text)["parameters"]
        for name, entry in told.items():
            if name in again and again[name]["value"] != entry["value"]:
                raise Misread(
                    f"parameter value: {name} is {again[name]['value']!r} where {entry['value']!r} was written"
                )


def write_diagnosis(draw: Draw, folder: Path) -> dict[str, Any]:
    """Write a diagnosis."""
    tree = changed(draw, json.loads((SEEDS / "diagnose.json").read_text()))
    (folder / "diagnose.json").write_bytes(damaged(draw, json.dumps(tree, default=str)))
    return {}


def read_diagnosis(folder: Path, written: dict[str, Any]) -> None:
    """Read it, and write its effects again."""
    from mechid.identification.result.diagnosis_file import read_diagnosis

    for one in read_diagnosis(folder / "diagnose.json")["missing"]:
        one.to_dict()


INPUTS = {"mechanism": "a" * 8}
RESULTS = (np.array([[1.5, -2.0], [0.1, 1e-300]]), {"a": 3.0, "b": [1, "x", None]}, [float("nan"), True], 3, None)


def write_journal(draw: Draw, folder: Path) -> dict[str, Any]:
    """Have a journal written with steps of every kind of result; change entries, whose digests are right in half."""
    from mechid.identification.computation.journal import Journal

    path = folder / "journal.jsonl"
    journal = Journal.open(path, INPUTS)
    for k, result in enumerate(RESULTS):
        journal.step("s", [k], partial(_given, result))
    whole = path.read_text()
    lines = [json.loads(line) for line in whole.splitlines()]
    changes = changed(draw, {"lines": lines}).get("lines", [])
    changes = changes if isinstance(changes, list) else [changes]
    as_text = _sealed if draw.chance(0.5) else json.dumps
    path.write_bytes(damaged(draw, "".join(as_text(plain(one)) + "\n" for one in changes), 0.2))
    return {"is_whole": path.read_text(errors="replace") == whole}


def _sealed(entry: Any) -> str:
    """Return a line as a journal writes it, whatever stands in it."""
    from mechid.identification.computation.journal import seal

    if not isinstance(entry, dict):
        return json.dumps(entry)
    return seal({key: value for key, value in entry.items() if key != "check"})


def _given(result: Any) -> Any:
    return result


def read_journal(folder: Path, written: dict[str, Any]) -> None:
    """Take up the run, and every step from it."""
    from mechid.identification.computation.journal import Journal, last_run

    path = folder / "journal.jsonl"
    last_run(path)
    journal = Journal.open(path, INPUTS, resume=True)
    for k in range(len(RESULTS)):
        journal.step("s", [k], partial(_given, 1))
    if written["is_whole"] and journal.saved_s == 0.0:
        raise Misread("steps: none is taken from a journal that is whole")


TEXTS = (
    *TOMLS,
    Kind("estimate", write_estimate, read_estimate, weight=4),
    Kind("diagnosis", write_diagnosis, read_diagnosis),
    Kind("journal", write_journal, read_journal, codes=(2,), weight=2),
)
