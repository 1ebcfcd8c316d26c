"""Three structures for the demo's records, side by side: the one that made them, one detent less, a rigid housing.

    python benchmarks/rivals.py FOLDER

The bench is that of `mechid demo`, its sweep held out. Rivals start at the values of the first fit, without the part
in question, in one stage that frees everything on all records. What `mechid compare` prints of them is in
docs/validation.md.
"""

import subprocess
import sys
from pathlib import Path

from mechid.campaign import load_mechanism

DETENT = "[[stepper.detent]]"
HOUSING = "[housing]"
SWEEP = 'file = "sweep.csv"\n'
WITH_SWEEP_HELD_OUT = SWEEP + 'use = "validate"\n'


def main(folder: Path) -> None:
    """Make the bench, fit the three, and compare them."""
    mechid("demo", "--out", folder)
    campaign = (folder / "campaign.toml").read_text().replace(SWEEP, WITH_SWEEP_HELD_OUT)
    (folder / "held_out.toml").write_text(campaign)
    mechid("identify", folder / "held_out.toml", "--out", folder / "two_detents_and_housing")
    found = (folder / "two_detents_and_housing" / "mechanism.toml").read_text()
    rivals = {"without_the_first_detent": without(found, DETENT), "rigid_housing": without(found, HOUSING)}
    fits = [fitted(folder, name, campaign, text) for name, text in rivals.items()]
    mechid("compare", folder / "two_detents_and_housing", *fits)


def without(mechanism: str, table: str) -> str:
    """Return a mechanism.toml without the first table of a name."""
    before, rest = mechanism.split(table, 1)
    end = rest.find("\n[")
    return before + (rest[end:] if end >= 0 else "")


def fitted(folder: Path, name: str, campaign: str, mechanism: str) -> Path:
    """Fit a mechanism in one stage from the values that it states; return the folder of the fit."""
    path = folder / f"{name}_mechanism.toml"
    path.write_text(mechanism)
    free = [p.name for p in load_mechanism(path).free]
    named = campaign.replace('mechanism = "mechanism.toml"', f'mechanism = "{path.name}"')
    (folder / f"{name}.toml").write_text(f"{named}\n[[stage]]\nfree = {free}\n")
    mechid("identify", folder / f"{name}.toml", "--out", folder / name)
    return folder / name


def mechid(*arguments: object) -> None:
    """Run a command of mechid."""
    subprocess.run([sys.executable, "-m", "mechid", *map(str, arguments)], check=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
