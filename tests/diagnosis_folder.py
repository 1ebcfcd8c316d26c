"""What mechid diagnose leaves, written by hand: effects at made up values, and the mechanism that has them."""

import json
import tomllib

from layouts import mechanism_of
from mechid.campaign import mechanism_text
from mechid.identification.result.diagnosis_file import FILE_NAME, FORMAT, PROPOSED_NAME
from mechid.identification.result.missing_effects import EffectValue, Missing

DETENT = ("stepper.detent.1.amplitude", "stepper.detent.1.phase_deg")
TRIED = ({"name": "gear.backlash", "words": "backlash of the gear", "why": "explains 2 % of the misfit in a fit"},)


def missing(name, values, block, aliases=()):
    own = {n: EffectValue(value=v, std_error=1e-3, unit="1") for n, v in values.items()}
    return Missing(
        name=name,
        words=f"what {name} is",
        parameters=own,
        chi_square=900.0,
        dof=len(own),
        share=0.9,
        p_value=0.0,
        records=("full_46",),
        toml="",
        block=block,
        aliases=aliases,
    )


def left(folder, proposed, *effects, **changes):
    """Leave what mechid diagnose leaves."""
    content = {
        "format": FORMAT,
        "missing": [one.to_dict() | {"frequencies_hz": {}} for one in effects],
        "tried": TRIED,
        "steps": [],
        "unexplained": {"share": 0.0, "words": "What is said of the whole."},
        "over_noise": {"as_written": 1.3, "with_effects": 1.0},
        **changes,
    }
    (folder / FILE_NAME).write_text(json.dumps(content), encoding="utf-8")
    if proposed is not None:
        (folder / PROPOSED_NAME).write_text(mechanism_text(proposed), encoding="utf-8")
    return folder


def less(mechanism, *entries):
    """Return a mechanism whose file lacks some tables."""
    table = tomllib.loads(mechanism_text(mechanism))
    for entry in entries:
        table.pop(entry) if entry in table else table["stepper"]["detent"].pop(1)
    return mechanism_of(table)


def detent(whole):
    values = {name: whole.value(name) for name in DETENT}
    return missing("stepper.detent:3.6deg", values, "stepper.detent", aliases=("stepper.imbalance",))
