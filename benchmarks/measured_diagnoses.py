"""What `mechid diagnose` says of measured mechanisms: what it names, what records held out say of it, and both halves.

Each campaign of examples/measured/ is fitted and diagnosed whole; where one record makes it up, also the first half of
its samples alone and the second half alone, from the values of the whole.

    MECHID_DATA=FOLDER python benchmarks/measured_diagnoses.py [NAME ...]
"""

import sys
import tempfile
import time
from pathlib import Path

from measured_halves import copied, half
from mechid.identification.diagnosis.diagnosis import Diagnosis, diagnose
from mechid.identification.identify import identify
from mechid.identification.result.fit import Fit
from mechid.identification.result.grade import Grade

NAMES = ("stepper", "emps", "emps_by_direction", "pendulum", "robot_axis", "servo")


def main() -> None:
    """Diagnose each campaign and print what is said."""
    for name in sys.argv[1:] or NAMES:
        with tempfile.TemporaryDirectory() as folder:
            campaign = copied(name, Path(folder))
            fit = identify(campaign)
            print(f"{name}: grade {fit.grade}, {said(fit)}", flush=True)
            if len(campaign.estimated) == 1:
                for k, which in enumerate(("first", "second")):
                    part = half(campaign, fit, k)
                    print(f"  {which} half: {said(identify(part))}", flush=True)


def said(fit: Fit) -> str:
    """Return what a diagnosis names, what is left, and how records held out are predicted without and with it."""
    if fit.grade == Grade.FAILED:
        return "the fit has failed"
    began = time.process_time()
    found = diagnose(fit)
    before, after = found.over_noise
    held = "; ".join(f"{h.record} {h.before:.3g} to {h.after:.3g}" for h in found.held_out)
    held = f"; held out: {held}" if held else ""
    took = time.process_time() - began
    return f"{named(found)}; {before:.3g} to {after:.3g} times the noise, {took:.0f} s CPU{held}; {found.words}"


def named(found: Diagnosis) -> str:
    """Return the effects with their aliases and shares, or that there is none."""
    return (
        ", ".join(f"{'|'.join((m.name, *m.aliases))} ({100 * m.share:.0f} %)" for m in found.missing) or "nothing named"
    )


if __name__ == "__main__":
    main()
