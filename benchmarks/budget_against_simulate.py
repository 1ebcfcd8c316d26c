"""The budget's torque beside `simulate`: lines and RMS of every block of the library, in full steps and microsteps.

The budget finds the motion that repeats by shooting and its lines behind a filter; `simulate` runs the mechanism from
rest for 12 s and more at 0.8 and 1.6 MHz, and its lines are those of the last whole periods, extrapolated to a sample
of no length, since a sample that holds a jump is its mean. No housing, no noise.

    python benchmarks/budget_against_simulate.py [LAYOUT ...]
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from flown import CASES, COMMANDS, compared


def main() -> None:
    """Print a row a mechanism and stepping."""
    print("| mechanism | stepping | repeats after | lines above the floor | worst of them | RMS, N m | its error |")
    print("|---|---|---|---|---|---|---|")
    for name in sys.argv[1:] or CASES:
        for stepping in COMMANDS:
            c = compared(name, stepping)
            repeats = c.steps * c.periods if c.periods else "never"
            worst = f"{np.max(c.off, initial=0.0):.1e}" if c.periods else "-"
            counted = f"{c.off.size} of {c.lines}"
            row = (name, stepping, f"{repeats} steps", counted, worst, f"{c.rms:.6f}", f"{c.rms_off:.1e}")
            print(f"| {' | '.join(row)} |", flush=True)


if __name__ == "__main__":
    main()
