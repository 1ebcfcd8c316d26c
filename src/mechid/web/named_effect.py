"""Effect named by a diagnosis, with its null values and its switch on the page."""

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
    """Effect named by a diagnosis.

    Attributes
    ----------
    name, words : str
    share : float
        Share of the misfit that the effect explains.
    aliases : mapping of str to str
        Effects that the records cannot distinguish from it: names with descriptions, if known.
    found : mapping of str to float
        Its parameters by dotted name, at the found values.
    nulls : mapping of str to float
        Null values of its parameters; empty if no value removes the effect.
    follows : mapping of str to str
        Per-record parameters, with the parameters whose values they take while the effect is off.
    free : frozenset of str
        Parameters that a fit may change while the effect is on.
    is_of_records : bool
        Whether the effect belongs to the records instead of the mechanism.
    why_fixed : str
        Reason why it has no switch; empty if it has one.
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
        """Dotted names of the tables and list entries of its parameters; empty for effects of records."""
        return set() if self.is_of_records else {name.rpartition(".")[0] for name in self.found}

    def nulls_at(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return the null values, given the values of all parameters."""
        return {name: values.get(self.follows.get(name, ""), null) for name, null in self.nulls.items()}

    def is_on(self, values: Mapping[str, float]) -> bool:
        """Return whether the effect is present at the given values."""
        # An effect without null values cannot be switched off.
        return not self.nulls or any(values.get(name, null) != null for name, null in self.nulls_at(values).items())
