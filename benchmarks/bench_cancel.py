"""From the explorer's cancel to the end of its fit.

    python benchmarks/bench_cancel.py mechid-demo/campaign.toml

So many searches for a start, each cancelled a little later than the one before; those that ended first do not count.
"""

import statistics
import sys
import time

from mechid.campaign import load_campaign
from mechid.web import Source
from mechid.web.session import Session

FITS, FIRST_S, LAST_S, LONGEST_S = 32, 0.5, 6.0, 60.0


def main(campaign: str) -> None:
    """Print the median and the longest time."""
    source = Source(load_campaign(campaign))
    instants = [FIRST_S + (LAST_S - FIRST_S) * k / (FITS - 1) for k in range(FITS)]
    taken = [ms for at in instants if (ms := cancelled(source, at)) is not None]
    print(f"{len(taken)} fits cancelled: median {statistics.median(taken):.0f} ms, longest {max(taken):.0f} ms")


def cancelled(source: Source, at_s: float) -> float | None:
    """Return how long a fit works on behind its cancel, ms; None where it was done before."""
    session = Session(source)
    session.search()
    time.sleep(at_s)
    if not session.is_fitting:
        return None
    session.cancel()
    began = time.perf_counter()
    if not session.run.wait(LONGEST_S):
        raise SystemExit(f"still at work {LONGEST_S:g} s behind its cancel at {at_s:.1f} s")
    return 1e3 * (time.perf_counter() - began)


if __name__ == "__main__":
    main(sys.argv[1])
