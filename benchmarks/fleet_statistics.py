"""How a fleet's statistics keep their promises, on drawn fleets whose truth is known. Synthetic, no identification.

Each row is a number of units and a spread in the estimates' typical error; errors of units differ by up to a factor 4.
Three ways to the variance from unit to unit, side by side on the same draws: Paule and Mandel's, which mechid uses,
DerSimonian and Laird's, and restricted maximum likelihood. Then the share of false findings, the power for outliers,
and the recovery of a slope.

    python benchmarks/fleet_statistics.py [DRAWS]
"""

import sys

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.special import stdtrit

from mechid.fleets.fleet import fleet_outliers
from mechid.fleets.observations import UnitValues
from mechid.fleets.outliers import farthest
from mechid.fleets.regression import regression
from mechid.fleets.significance import apply_fdr
from mechid.fleets.spread import spread

UNITS, SPREADS = (3, 5, 10, 20), (0.0, 0.5, 1.0, 4.0)
PARAMETERS = 15


def main() -> None:
    """Print the tables."""
    draws = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    print(f"{draws} draws a row\n")
    print("| units | spread | mean in its 95 %: PM | DL | REML | spread in its 95 % | further in its 95 % | differs |")
    print("|---|---|---|---|---|---|---|---|")
    for n in UNITS:
        for size in SPREADS:
            print(coverage_row(n, size, draws), flush=True)
    print("\n| units, errors | false share of parameters that differ | fleets with a false outlier |")
    print("|---|---|---|")
    for n in UNITS[1:]:
        print(false_row(n, draws // 2), flush=True)
    print("\n| units | stand off by, spreads | one found | two on one side, both found | others named |")
    print("|---|---|---|---|---|")
    for n in UNITS[2:]:
        for off in (4.0, 6.0, 8.0):
            print(outlier_row(n, off, draws // 4), flush=True)
    print("\n| units | spread | slope in its 95 % |")
    print("|---|---|---|")
    for n in UNITS[1:]:
        for size in (0.0, 1.0, 4.0):
            print(slope_row(n, size, draws), flush=True)


def drawn(rng: np.random.Generator, n: int, size: float, mean: float = 3.0) -> tuple[np.ndarray, np.ndarray]:
    """Return values and errors of n units."""
    errors = 2.0 ** rng.uniform(-1.0, 1.0, n)
    return mean + size * rng.standard_normal(n) + errors * rng.standard_normal(n), errors


def coverage_row(n: int, size: float, draws: int) -> str:
    """Return how often mean, spread and a further unit lie in their intervals."""
    rng, hits = np.random.default_rng([n, round(10.0 * size)]), np.zeros((draws, 6))
    for k in range(draws):
        y, s = drawn(rng, n, size)
        made = spread(UnitValues(units=tuple(map(str, range(n))), values=y, errors=s, repeatability=np.nan))
        further = 3.0 + size * rng.standard_normal()
        others = [inside(y, s, way(y, s)) for way in (dersimonian_laird, restricted_likelihood)]
        low, high = made.spread95
        hits[k] = (
            made.mean95[0] < 3.0 < made.mean95[1],
            *others,
            low <= size <= high,
            made.next95[0] < further < made.next95[1],
            made.equal_p < 0.05,
        )
    shares = " | ".join(f"{100.0 * share:.1f}" for share in hits.mean(axis=0))
    return f"| {n} | {size:g} | {shares} |"


def inside(y: np.ndarray, s: np.ndarray, tau2: float) -> bool:
    """Whether the mean lies in its 95 % interval, by Hartung and Knapp with a factor of at least 1."""
    w = 1.0 / (s**2 + tau2)
    mean = w @ y / w.sum()
    factor = max(1.0, w @ (y - mean) ** 2 / (y.size - 1))
    return bool(abs(mean - 3.0) < stdtrit(y.size - 1, 0.975) * np.sqrt(factor / w.sum()))


def dersimonian_laird(y: np.ndarray, s: np.ndarray) -> float:
    """Return tau^2 by moments with the weights of errors alone."""
    w = 1.0 / s**2
    q = w @ (y - w @ y / w.sum()) ** 2
    return float(max(0.0, (q - (y.size - 1)) / (w.sum() - (w**2).sum() / w.sum())))


def restricted_likelihood(y: np.ndarray, s: np.ndarray) -> float:
    """Return tau^2 of the restricted likelihood."""

    def cost(tau: float) -> float:
        w = 1.0 / (s**2 + tau**2)
        return float(-np.log(w).sum() + np.log(w.sum()) + w @ (y - w @ y / w.sum()) ** 2)

    top = 3.0 * float(np.std(y)) + 1e-6
    return float(minimize_scalar(cost, bounds=(0.0, top), method="bounded").x) ** 2


def correlated(rng: np.random.Generator, n: int, size: float) -> list[UnitValues]:
    """Return 15 parameters of n units, the estimates of each unit correlated as those of a fit, by up to 0.9."""
    mixing = rng.standard_normal((PARAMETERS, 3))
    covariance = mixing @ mixing.T + 0.3 * np.eye(PARAMETERS)
    scale = np.sqrt(np.diag(covariance))
    noise = rng.multivariate_normal(np.zeros(PARAMETERS), covariance / np.outer(scale, scale), n).T
    errors = 2.0 ** rng.uniform(-1.0, 1.0, (PARAMETERS, n))
    values = size * rng.standard_normal((PARAMETERS, n)) + errors * noise
    names = tuple(map(str, range(n)))
    return [
        UnitValues(units=names, values=v, errors=e, repeatability=np.nan) for v, e in zip(values, errors, strict=True)
    ]


def false_row(n: int, draws: int) -> str:
    """Return the share of fleets of equal units with any finding, and of spread units with any outlier."""
    rng, differ, off = np.random.default_rng(100 + n), 0, {0.0: 0, 4.0: 0}
    for _ in range(draws):
        for size in off:
            made = {str(k): spread(one) for k, one in enumerate(correlated(rng, n, size))}
            if size == 0.0:
                differ += any(one.found for one in apply_fdr(list(made.values()), 0.05, lambda s: s.equal_p))
            off[size] += any(fleet_outliers({name: one.standings for name, one in made.items()}, 0.05).values())
    counted = ", ".join(f"spread {size:g}: {100.0 * count / draws:.1f} %" for size, count in off.items())
    return f"| {n}, correlated | {100.0 * differ / draws:.1f} % | {counted} |"


def outlier_row(n: int, off: float, draws: int) -> str:
    """Return how often units that stand off are found among 15 parameters, their spread four errors."""
    rng, counts = np.random.default_rng(200 + n), np.zeros(3)
    for _ in range(draws):
        for moved in (1, 2):
            fleet = correlated(rng, n, 4.0)
            fleet[0].values[:moved] += off * 4.0
            found = fleet_outliers({str(k): farthest(one.values, one.errors) for k, one in enumerate(fleet)}, 0.05)
            units = {one.unit for one in found.get("0", ())}
            counts[moved - 1] += set(range(moved)) <= units
            counts[2] += sum(one.unit >= moved or name != "0" for name, all_ in found.items() for one in all_) / 2.0
    one, two, others = counts / draws
    return f"| {n} | {off:g} | {100.0 * one:.0f} % | {100.0 * two:.0f} % | {others:.2f} a fleet |"


def slope_row(n: int, size: float, draws: int) -> str:
    """Return how often a slope lies in its interval."""
    rng, hits = np.random.default_rng([300, n, round(10.0 * size)]), 0
    for _ in range(draws):
        y, s = drawn(rng, n, size)
        x = rng.uniform(-1.0, 1.0, n)
        made = regression(y + 2.0 * x, s, np.column_stack([x, np.ones(n)]))
        low, high = made.interval()
        hits += low < 2.0 < high
    return f"| {n} | {size:g} | {100.0 * hits / draws:.1f} |"


if __name__ == "__main__":
    main()
