"""Effects and their rivals that `mechid design` reads from a diagnosis."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from mechid.campaign.mechanism_file import load_mechanism
from mechid.identification.effects.disturbance import MAINS_PREFIX
from mechid.identification.result.diagnosis_file import FILE_NAME, PROPOSED_NAME, read_diagnosis
from mechid.identification.result.missing import Missing
from mechid.plant.mechanism import Mechanism


@dataclass(frozen=True, eq=False)
class Diagnosed:
    """What a diagnosis has found.

    Attributes
    ----------
    path : Path
        Of diagnose.json.
    effects : tuple of Missing
        Mains hum, which is removed from the records, is none of them.
    over_noise : float
        RMS over that of the noise of what the mechanism with these effects leaves.
    mechanism : Mechanism or None
        With these effects, at their values; None where there are none.
    """

    path: Path
    effects: tuple[Missing, ...]
    over_noise: float
    mechanism: Mechanism | None

    @property
    def groups(self) -> tuple[Missing, ...]:
        """The effects that have rivals."""
        return tuple(effect for effect in self.effects if effect.aliases)


def read_diagnosed(folder: Path | str) -> Diagnosed:
    """Return what a folder of ``mechid diagnose`` holds.

    Raises
    ------
    InputFileError
        A file is missing, damaged, or not of the format; one line.
    """
    path = Path(folder) / FILE_NAME
    content = read_diagnosis(path)
    effects = tuple(one for one in content["missing"] if not one.name.startswith(MAINS_PREFIX))
    mechanism = load_mechanism(path.parent / PROPOSED_NAME) if effects else None
    return Diagnosed(path, effects, content["over_noise"]["with_effects"], mechanism)
