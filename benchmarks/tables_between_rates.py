"""How far the loads of an export's tables are off between the rates at which they are tabulated.

The lines of a result folder are worked out half way between all neighbouring rates of its default grid, and set beside
what Nastran makes of the tables there: straight lines of the real and the imaginary part over the frequency. Errors are
relative to the largest line of the same order at any rate.

    python benchmarks/tables_between_rates.py FIT [CAMPAIGN]
"""

import sys
from pathlib import Path

import numpy as np

from mechid.exports.forcing import estimate_on_base, forcing
from mechid.exports.handover import handover
from mechid.exports.run import read_with_campaign
from mechid.exports.stepping import choose_rates, steppings
from mechid.exports.tables.bulk import order_loads

ORDERS = 4.0
"""Up to here a row each; all together below."""


def main() -> None:
    """Print a row an order and stepping."""
    folder, campaign = Path(sys.argv[1]), Path(sys.argv[2]) if len(sys.argv) > 2 else None
    what = handover(*read_with_campaign(folder, campaign)[:2])
    estimate, ways = estimate_on_base(what), steppings(what.trials)
    rates = choose_rates(estimate.mechanism, ways)
    print("| stepping | order | largest line, N m | median error | 95 % of rates below | largest | at steps/s |")
    print("|---|---|---|---|---|---|---|")
    for way in ways:
        between = forcing(estimate, way, 0.5 * (rates[1:] + rates[:-1]))
        rows = list(compared(order_loads(forcing(estimate, way, rates)), between))
        for order, largest, off, at in rows:
            if order <= ORDERS:
                print_row(way.name, f"{order:g}", f"{largest:.3g}", off, f"{at:.4g}")
        print_row(way.name, f"all {len(rows)}", "", np.concatenate([off for _, _, off, _ in rows]), "")


def compared(loads, between):
    """Yield order, largest line, relative errors, and the rate of the largest, of each order that has a line."""
    for load in loads:
        lines = dict(lines_of(between, load.order))
        rates = np.array([r for r in lines if load.frequency_hz[0] <= r * load.order <= load.frequency_hz[-1]])
        if not rates.size or not np.any(load.lines):
            continue
        known, x = np.array([lines[r] for r in rates]), rates * load.order
        parts = (np.interp(x, load.frequency_hz, part) for part in (load.lines.real, load.lines.imag))
        largest = np.abs(load.lines).max()
        off = np.abs(next(parts) + 1j * next(parts) - known) / largest
        yield load.order, largest, off, rates[off.argmax()]


def lines_of(between, order):
    """Yield rate and line of an order where there is one."""
    for rate, at in zip(between.mode.rates, between.emissions, strict=True):
        for line in at.modelled[at.orders == order]:
            yield rate, line


def print_row(name, order, largest, off, at):
    """Print one row."""
    errors = (np.median(off), np.quantile(off, 0.95), off.max())
    print(f"| {name} | {order} | {largest} | {' | '.join(f'{100.0 * e:.2g} %' for e in errors)} | {at} |", flush=True)


if __name__ == "__main__":
    main()
