"""An effect that a diagnosis names, as the page has it: what it is, where there is nothing of it, its switch."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

IN_PLACE = (
    "no switch: it stands in place of what the mechanism file had, and none of its values means that it is not there; "
    "without --diagnosis the page shows the mechanism as written, and the estimate of it"
)
NO_VALUE = "no switch: the records of this campaign have no such value to set here"
OF_RECORDS = "it is of the records: its values stand in the campaign file, and Save mechanism.toml leaves them out"


@dataclass(frozen=True, kw_only=True)
class NamedEffect:
    """An effect that a diagnosis names.

    Attributes
    ----------
    name, words : str
    share : float
        Of the misfit, that it explains.
    aliases : mapping of str to str
        What these records cannot tell it from: names, and words where they are known.
    found : mapping of str to float
        Its parameters by dotted name, at the values found.
    nulls : mapping of str to float
        Where there is nothing of it; empty where no value is that.
    follows : mapping of str to str
        Values that records have of their own, and whose they have where it is off.
    free : frozenset of str
        Of its parameters, those that a fit may move where it is on.
    is_of_records : bool
        Whether it is none of the mechanism.
    why_fixed : str
        Why it has no switch; empty where it has one.
    """

    name: str
    words: str
    share: float
    aliases: Mapping[str, str]
    found: Mapping[str, float]
    nulls: Mapping[str, float] = field(default_factory=dict)
    follows: Mapping[str, str] = field(default_factory=dict)
    free: frozenset[str] = frozenset()
    is_of_records: bool = False
    why_fixed: str = ""

    @property
    def tables(self) -> set[str]:
        """Dotted names of the tables, and entries of lists, that its parameters stand in; none of records."""
        return set() if self.is_of_records else {name.rpartition(".")[0] for name in self.found}

    def nulls_at(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return where there is nothing of it beside the values of all else."""
        return {name: values.get(self.follows.get(name, ""), null) for name, null in self.nulls.items()}

    def is_on(self, values: Mapping[str, float]) -> bool:
        """Tell whether there is anything of it."""
        return not self.nulls or any(values.get(name, null) != null for name, null in self.nulls_at(values).items())
