"""Settings of the design of experiments: candidate rates, searches for rates that hold, and checks of predictions."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class DesignSettings:
    """Settings of candidates, criterion and selection.

    No benchmark distinguishes the values without a stated reason from others nearby.
    """

    rates: int = 12
    """Candidate rates where none are given."""
    above_resonance: float = 2.2
    """Highest of these rates, as a multiple of the load's resonance on the gear."""
    highest_rate: float = 120.0
    """Highest of these rates without such a resonance, full steps/s."""
    lowest_share: float = 1.0 / 16.0
    """Lowest of these rates, as a share of the highest."""
    guide: float = 1e-3
    """Weight of the D criterion in the others, which guides the search where they are flat."""
    low_quantile: float = 0.8
    """Quantile over the mechanisms that `low` judges by: four of five fare better."""
    next_s: float = 120.0
    """Test time after a fit, where none is given."""
    rate_margin: float = 1.2
    """Factor beyond the highest candidate rate up to which the amplitude is shown."""
    noise_nm: float = 0.002
    """Noise where neither a file nor the user gives it, N m."""
    same_ratio: float = 0.02
    """Relative difference of the residual-to-noise ratio up to which a diagnosis is of these records."""
    least_gain: float = 1e-6
    """Gain of the criterion below which a record is not added or exchanged."""
    most_rounds: int = 8
    """Rounds of exchange."""
    tried: int = 3
    """Records that are tried in place of one taken out, by each of two orders."""
    least_chi_square: float = 1.0
    """Chi-square that a further record of a set has to add."""
    chance: float = 2.0
    """Standard deviations by which chance may lower the expected separation."""
    mechanisms: int = 8
    """Mechanisms at which a record's promise is tested."""
    draws: int = 3
    """Draws at each of them."""
    farthest: float = 0.01
    """Longest step of a draw, as a share of a coordinate's size."""


@dataclass(frozen=True)
class RateSettings:
    """Settings of the simulations for rates that hold, step loss, and the torque over the rate."""

    lowest: float = 4.0
    """Lowest rate that is looked at, full steps/s."""
    highest: float = 4000.0
    """Highest rate that is looked at, full steps/s."""
    resolution: float = 0.005
    """Relative accuracy of the ends of a range."""
    far: float = 1.05
    """Ratio of neighbouring rates that are tried far from resonances."""
    near: float = 1.01
    """The same near resonances."""
    least: float = 1.0
    """Least distance of rates that are tried, full steps/s: half a second at a rate (`started_s`) does not separate
    rates that differ by less than half a period of what is left of them over that time."""
    around: tuple[float, float] = (0.25, 1.2)
    """Rates over a resonance's frequency at which it is met: from every fourth swing to a little above it. The torque
    is softer than a spring far from its middle, so a large swing is slower than the small one of the resonance."""
    swinging: float = 0.5
    """Damping ratio above which a swing does not build up from step to step."""
    sample_rate_hz: float = 10_000.0
    """Sample rate of these simulations."""
    hold_s: float = 0.4
    """Time held after the command."""
    at_rest_share: float = 0.25
    """Last part of it over which the rotor's angle is averaged."""
    started_s: float = 0.5
    """Time at the rate."""
    ramp_s: float = 1.0
    """Time from zero to the rate where the motor is brought there slowly."""
    slow_ratio: float = 1.1
    """Ratio of neighbouring rates to which the motor is brought slowly: it has passed all that are lower."""
    inertia_factors: tuple[float, ...] = (0.25, 0.5, 2.0, 4.0, 8.0)
    """Load inertias of the loss table, over the mechanism's."""
    voltage_factors: tuple[float, ...] = (0.6, 0.8, 1.2)
    """Supply voltages of the loss table, over the mechanism's."""
    torque_shares: tuple[float, ...] = (0.1, 0.2, 0.4)
    """Dry friction that the loss table adds at the rotor, as shares of the holding torque k_m U / R."""
    bins: int = 120
    """Most bins of a map of the torque over the rate."""
    least_bins: int = 10
    """Fewest bins of it."""
    narrowest: float = 0.05
    """Least width of a bin, full steps/s: a narrower one would take minutes of motion and show nothing else."""
    settled_s: float = 1.0
    """Rest before the sweep: what the start leaves swinging is the torque of no rate."""
    shortest_s: float = 1.0
    """Least time in each bin, for resonances to build up."""
    longest_s: float = 20.0
    """Most time in each bin, for a motion that repeats only after many electrical periods, as over a rotor's turn; one
    of them is always held."""
    prominence: float = 0.15
    """Height of a peak over its surroundings, as a share of the largest amplitude."""


DESIGN = DesignSettings()
RATE = RateSettings()
