"""Tables of searches from the catalogue: how many are followed, what they name, what they cost, whether errors hold."""

from collections.abc import Mapping, Sequence
from statistics import median

import numpy as np

from incomplete.effects import NOTHING
from incomplete.names import entries_of, false_names, names_of, unnamed, with_equivalents
from incomplete.summary import errors_of

GOOD = ("A", "B")
SIGMAS = 3.0
WHOLE_PERCENT = 99.9
"""Share of a record from which on it counts as followed to its end: single windows may be out of step."""
PREDICTABLE = 0.5
ASKED = {"followed": 0.92, "family": 4 / 6, "pairs": 0.80, "median": 45.0, "worst": 200.0, "exact": 0.85, "false": 0.05}
ASKED_WITHIN = 0.95
"""What is asked for: shares, and CPU s of the whole command on one core."""
Lines = Sequence[Mapping]


def is_followed(line: Mapping) -> bool:
    """Tell whether a search follows all records to their ends and is of grade A or B."""
    shares = line["followed"].values()
    return line["grade"] in GOOD and bool(shares) and min(shares) >= WHOLE_PERCENT


def is_predictable(line: Mapping) -> bool:
    """Tell whether the true model itself, next to nothing off, follows all records to their ends."""
    return not any(at is not None for at in line["predictable_s"].values())


def reaches_chaos(line: Mapping) -> bool:
    """Tell whether a search follows each record for `PREDICTABLE` of the time for which the truth can be told.

    A fit is some hundred times as far from the truth as the change by which that time is measured.
    """
    ends, reached = line["predictable_s"], line["horizon_s"]
    whole = {name for name, share in line["followed"].items() if share >= WHOLE_PERCENT}
    rest = [(reached.get(name) or 0.0, end) for name, end in ends.items() if name not in whole]
    return bool(reached) and all(end is not None and at >= PREDICTABLE * end for at, end in rest)


def right_names(line: Mapping) -> list[str]:
    """Return the names of the effects that are missing."""
    return names_of(line["effect"], line["size"])


def is_named(line: Mapping) -> bool:
    """Tell whether the missing effects, or what stands for the same, are in the fit and no other."""
    return not wrong_names(line) and not unnamed(right_names(line), with_equivalents(entries_of(line)))


def wrong_names(line: Mapping) -> list[str]:
    """Return the names in the fit that stand for none of the missing effects."""
    return false_names(right_names(line), with_equivalents(entries_of(line)))


def said_of(line: Mapping) -> str:
    """Return a search's line of progress."""
    names = ", ".join("|".join(entry) for entry in entries_of(line)) or "nothing"
    errors = [abs(z) for _, z in errors_of(line)]
    return (
        f"{line['effect']:32} {line['seed']:4d}  {line['cpu_s']:6.1f} s CPU  grade {line['grade']:6} "
        f"{'followed' if is_followed(line) else 'LOST':8}  {'exact' if is_named(line) else 'WRONG'}  "
        f"largest error {max(errors, default=float('nan')):.1f} sigma  {names}  {' '.join(line['said'][-1:])}"
    )


def search_table(lines: Lines) -> str:
    """Return the summary of searches: a row for each effect and group, and what was asked for."""
    head = f"{'from the catalogue':42} searches  followed (A or B)  CPU s: median  worst  exact names   false names"
    rows = ["", f"{head}   within {SIGMAS:g} sigma"]
    for words, own in _groups(lines).items():
        rows += [_row(words, own)] if own else []
    rows += ["", *_against_asked(_groups(lines))]
    chaotic = [line for line in lines if not is_predictable(line)]
    kinds = ", ".join(dict.fromkeys(line["effect"] for line in chaotic)) or "none"
    rows.append(
        f"not predictable to their ends by the true model itself: {len(chaotic)} of {len(lines)} ({kinds}); "
        f"followed for {PREDICTABLE:.0%} of what is: {sum(map(reaches_chaos, chaotic))}"
    )
    return "\n".join(rows)


def _groups(lines: Lines) -> dict[str, Lines]:
    """Return the lines by effect, and those of one effect, of two, of nothing, and of the second simulator."""
    effects = dict.fromkeys(line["effect"] for line in lines)
    single = [line for line in lines if "+" not in line["effect"] and line["effect"] != NOTHING]
    return {
        **{effect: [line for line in lines if line["effect"] == effect] for effect in effects},
        "one effect": single,
        "  predictable to the ends": [line for line in single if is_predictable(line)],
        "  by the second simulator": [line for line in single if line["simulator"] == "by_events"],
        "two effects": [line for line in lines if "+" in line["effect"]],
    }


def _row(words: str, own: Lines) -> str:
    good, exact = sum(map(is_followed, own)), sum(map(is_named, own))
    cpu = [line["cpu_s"] for line in own]
    return (
        f"{words:42} {len(own):8d}  {good:3d} ({good / len(own):4.0%})         {median(cpu):11.1f} {max(cpu):6.1f}  "
        f"{exact:3d} ({exact / len(own):4.0%})   {_told_false(own):12}  {_within(own)}"
    )


def _false_share(own: Lines) -> tuple[int, int]:
    return sum(len(wrong_names(line)) for line in own), sum(len(line["missing"]) for line in own)


def _told_false(own: Lines) -> str:
    return "{} of {}".format(*_false_share(own))


def _within_share(own: Lines) -> float | None:
    """Return the share of the parameters of followed fits that are within `SIGMAS` stated errors of the truth."""
    errors = [abs(z) for line in own if is_followed(line) for _, z in errors_of(line)]
    return float(np.mean([z <= SIGMAS for z in errors])) if errors else None


def _within(own: Lines) -> str:
    share = _within_share(own)
    return "none" if share is None else f"{share:6.1%}"


def _against_asked(groups: Mapping[str, Lines]) -> list[str]:
    """Return what the searches of one and of two effects reach beside what is asked for."""
    single, pairs, rows = groups["one effect"], groups["two effects"], []
    if single:
        exact = np.mean([is_named(one) for one in single])
        cpu = [line["cpu_s"] for line in single]
        false, every = _false_share(single)
        families = {name: own for name, own in groups.items() if own and all(one in single for one in own)}
        low = [
            f"{name} {sum(map(is_followed, own))} of {len(own)}"
            for name, own in families.items()
            if not name.startswith((" ", "one ")) and np.mean([is_followed(one) for one in own]) < ASKED["family"]
        ]
        rows += [
            f"followed, A or B:  {np.mean([is_followed(one) for one in single]):6.1%}  asked {ASKED['followed']:.0%}",
            f"families below {ASKED['family']:.0%}:  {', '.join(low) or 'none'}",
            f"CPU s of the whole command:  median {median(cpu):.1f}, asked {ASKED['median']:g}; "
            f"worst {max(cpu):.1f}, asked {ASKED['worst']:g}",
            f"exactly the missing effect:  {exact:6.1%}  asked {ASKED['exact']:.0%}",
            f"false names:  {false / max(every, 1):6.1%}  asked at most {ASKED['false']:.0%}",
            f"parameters within {SIGMAS:g} sigma:  {_within(single)}  asked {ASKED_WITHIN:.0%}",
        ]
    if pairs:
        share = np.mean([is_followed(one) for one in pairs])
        rows.append(f"two effects, followed, A or B:  {share:6.1%}  asked {ASKED['pairs']:.0%}")
    return rows
