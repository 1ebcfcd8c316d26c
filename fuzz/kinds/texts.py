"""What mechid itself has written and reads again: estimates, diagnoses, journals."""

import json
import shutil
from pathlib import Path
from typing import Any

from fuzz.draw import Draw
from fuzz.kinds.tomls import SEEDS, TOMLS
from fuzz.tree import changed, damaged, leaves
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
    from mechid.fleets.estimates import read_unit
    from mechid.identification.result.estimate_file import estimate_text, read_estimate
    from mechid.identification.result.fit_file import read_fit

    path = folder / "estimate.json"
    if written["asked"] == "estimate":
        read_estimate(path)
    elif written["asked"] == "unit":
        read_unit(folder)
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


STEP = {"shape": [2, 2], "hex": " ".join(float(x).hex() for x in (1.5, -2.0, 0.1, 1e-300))}


def write_journal(draw: Draw, folder: Path) -> dict[str, Any]:
    """Write a journal with steps of every kind of result."""
    from mechid.identification.computation.journal import digest, with_version

    start = {"time": "t", "event": "started", "campaign": "c", "inputs": with_version({"mechanism": "a" * 8})}
    results = (STEP, {"items": [["a", {"hex": "0x1.8p+1"}], ["b", [1, "x", None]]]}, [STEP, {"hex": "nan"}], 3, None)
    steps = [
        {
            "time": "t",
            "event": "step",
            "step": "s",
            "key": digest(["s", [k], None]),
            "seconds": 1.0,
            "result": r,
            "rng": None,
        }
        for k, r in enumerate(results)
    ]
    tree = changed(draw, {"lines": [start, *steps, {"time": "t", "event": "finished"}]})
    lines = tree.get("lines", [])
    text = "\n".join(json.dumps(line, default=str) for line in (lines if isinstance(lines, list) else [lines])) + "\n"
    (folder / "journal.jsonl").write_bytes(damaged(draw, text, 0.2))
    return {"steps": len(list(leaves(tree)))}


def read_journal(folder: Path, written: dict[str, Any]) -> None:
    """Take up the run, and every step from it."""
    from mechid.identification.computation.journal import Journal, last_run

    path = folder / "journal.jsonl"
    last_run(path)
    journal = Journal.opened(path, {"mechanism": "a" * 8}, resume=True)
    for k in range(5):
        journal.step("s", [k], lambda: 1)


TEXTS = (
    *TOMLS,
    Kind("estimate", write_estimate, read_estimate, weight=4),
    Kind("diagnosis", write_diagnosis, read_diagnosis),
    Kind("journal", write_journal, read_journal, codes=(2,), weight=2),
)
