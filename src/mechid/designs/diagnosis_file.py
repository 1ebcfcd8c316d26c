"""Reader of the effects and their alternatives in a diagnosis."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from mechid.campaign.mechanism_file import load_mechanism
from mechid.identification.effects.disturbance import MAINS_PREFIX
from mechid.identification.result.diagnosis_file import FILE_NAME, PROPOSED_NAME, read_diagnosis
from mechid.identification.result.missing_effects import Missing
from mechid.plant.mechanism import Mechanism


@dataclass(frozen=True, eq=False)
class DiagnosedEffects:
    """Result of a diagnosis as a design needs it.

    Attributes
    ----------
    path : Path
        Path of diagnose.json.
    effects : tuple of Missing
        Missing effects, except mains hum, which is removed from the records.
    over_noise : float
        Residual-to-noise ratio of the mechanism with these effects.
    mechanism : Mechanism or None
        Mechanism with these effects, at their values; None without effects.
    """

    path: Path
    effects: tuple[Missing, ...]
    over_noise: float
    mechanism: Mechanism | None

    @property
    def groups(self) -> tuple[Missing, ...]:
        """Effects that have alternatives."""
        return tuple(effect for effect in self.effects if effect.aliases)


def read_diagnosed(folder: Path | str) -> DiagnosedEffects:
    """Read a folder of ``mechid diagnose``.

    Raises
    ------
    InputFileError
        A file is missing, damaged, or has another format; one line.
    """
    path = Path(folder) / FILE_NAME
    content = read_diagnosis(path)
    effects = tuple(one for one in content["missing"] if not one.name.startswith(MAINS_PREFIX))
    mechanism = load_mechanism(path.parent / PROPOSED_NAME) if effects else None
    return DiagnosedEffects(path, effects, content["over_noise"]["with_effects"], mechanism)
