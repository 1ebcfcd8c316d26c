"""What a run has counted, in a file that it goes on from."""

import json
from collections import Counter
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from fuzz.trial import ACCEPTED, FINDING, REFUSED
from fuzz.worker import Tried
from mechid.writing import write_atomically

LAST = 20_000
"""Inputs that have to pass without a new branch."""


@dataclass
class Counts:
    """How many inputs of each kind had which outcome; `findings` by what tells their causes apart.

    Attributes
    ----------
    outcomes : dict
        By kind, the number of inputs by outcome.
    findings : dict
        By cause: words, and the inputs' numbers.
    taken : list of str
        Branches.
    news : list of (int, int)
        After how many inputs how many new branches were taken.
    """

    outcomes: dict[str, dict[str, int]] = field(default_factory=dict)
    findings: dict[str, dict[str, Any]] = field(default_factory=dict)
    taken: list[str] = field(default_factory=list)
    news: list[list[int]] = field(default_factory=list)

    @classmethod
    def read(cls, path: Path) -> "Counts":
        """Return what a file holds, nothing where there is none."""
        return cls(**json.loads(path.read_text())) if path.exists() else cls()

    def write(self, path: Path) -> None:
        """Write them whole."""
        write_atomically(path, json.dumps(asdict(self), indent=1))

    def next(self, kind: str) -> int:
        """Return the number of the next input of a kind."""
        return sum(self.outcomes.get(kind, {}).values())

    @property
    def total(self) -> int:
        """All inputs."""
        return sum(map(self.next, self.outcomes))

    @property
    def new_of_the_last(self) -> int:
        """Branches that the last inputs were the first to take."""
        return sum(count for at, count in self.news if at > self.total - LAST)

    def add(self, kind: str, tried: Tried) -> None:
        """Count an input."""
        outcome = tried.outcome
        of_kind = Counter(self.outcomes.get(kind, {}))
        of_kind[outcome.what] += 1
        self.outcomes[kind] = dict(of_kind)
        if tried.new:
            self.taken.extend(tried.new)
            self.news.append([self.total, len(tried.new)])
        if outcome.what == FINDING:
            found = self.findings.setdefault(outcome.where, {"words": outcome.words, "inputs": []})
            found["inputs"].append(tried.number)

    def forget(self, where: str) -> list[int]:
        """Return the inputs of a cause, which are counted no longer."""
        inputs = self.findings.pop(where)["inputs"]
        self.outcomes[where.partition(" ")[0]][FINDING] -= len(inputs)
        return inputs

    def table(self, branches: frozenset[str]) -> str:
        """Return the counts by kind as a Markdown table, and what was found."""
        rows = ["| kind | inputs | accepted | refused | findings |", "|---|---:|---:|---:|---:|"]
        for kind, found in sorted(self.outcomes.items()):
            refused = sum(count for what, count in found.items() if what.startswith(REFUSED))
            rows.append(_row(kind, self.next(kind), found.get(ACCEPTED, 0), refused, found.get(FINDING, 0)))
        totals = [
            sum(n for f in self.outcomes.values() for what, n in f.items() if what.startswith(w))
            for w in (ACCEPTED, REFUSED, FINDING)
        ]
        rows.append(_row("all", self.total, *totals))
        taken = len(branches.intersection(self.taken))
        rows += [
            "",
            f"branches taken: {taken} of {len(branches)}; by the last {LAST} inputs first: {self.new_of_the_last}",
        ]
        causes = sorted(self.findings.items(), key=lambda each: -len(each[1]["inputs"]))
        rows += [
            f"finding {len(f['inputs'])}x {where} (inputs {f['inputs'][:5]}): {f['words'][:200]}" for where, f in causes
        ]
        return "\n".join(rows)


def _row(*cells: object) -> str:
    return (
        "| "
        + " | ".join(f"{cell:,}".replace(",", " ") if isinstance(cell, int) else str(cell) for cell in cells)
        + " |"
    )
