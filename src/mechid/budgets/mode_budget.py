"""Budget of one mode of operation."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from mechid.arrays import ComplexArray, FloatArray
from mechid.budgets.emission import Emission
from mechid.budgets.line_of_sight import LineOfSight, Response
from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.orders import OrderMap
from mechid.budgets.over_rate import LevelCurve
from mechid.budgets.profile_run import ProfileResponse
from mechid.budgets.requirement import Requirement, Standing


@dataclass(frozen=True, eq=False)
class ModeBudget:
    """Results of one mode of operation.

    Attributes
    ----------
    mode : OperatingMode
    responses : tuple of Response, (r,)
        One-way, at each rate, for the steady state with the largest RMS; empty for a profile.
    states : tuple of tuple of Response, (r,)
        One-way, for all steady states found at each rate, the one from rest first.
    course : ProfileResponse or None
        Response over a profile.
    worst : int
        Position of the rate with the largest RMS along any line of sight.
    rms_band : (r, m, 2)
        95 % interval of the RMS of the lines at each rate, rad.
    total_band : (r, m, 2)
        95 % interval of the total RMS: lines, non-repeating part and unmodelled torque.
    emissions : tuple of Emission, (r,)
        The torque on the base at each rate, with its bound.
    two_way : tuple of Response, (r,) or none
        At each rate, with the structure's modes coupled; of the motions reached, the one with the largest RMS.
    two_way_course : ProfileResponse or None
        Two-way response over a profile.
    loop_gain : float
        Largest |receptance x dynamic stiffness| at the lines of the worst rate, for a profile up to the highest
        frequency; NaN if unknown.
    levels : mapping of requirement to LevelCurve
        One-way, over the rates of a steady mode.
    two_way_curves : mapping of requirement to LevelCurve
        Two-way, if the structure's modes are coupled with the mechanism.
    two_way_levels : mapping of requirement to (position, level)
        Level of the nominal unit over time, rad, and the worst rate of the two-way responses.
    standings : tuple of Standing
        At the worst rate of each requirement.
    deciding : mapping of requirement to LevelCurve
        Over the rates, for the deciding coupling, scaled to the level and band of the deciding margin.
    avoid : mapping of requirement to ranges
        Ranges of rate in which the upper 95 % end of the deciding level exceeds the limit; for a mode with several
        rates.
    """

    mode: OperatingMode
    responses: tuple[Response, ...] = ()
    states: tuple[tuple[Response, ...], ...] = ()
    course: ProfileResponse | None = None
    worst: int = 0
    rms_band: FloatArray = field(default_factory=lambda: np.zeros((0, 0, 2)))
    total_band: FloatArray = field(default_factory=lambda: np.zeros((0, 0, 2)))
    emissions: tuple[Emission, ...] = ()
    two_way: tuple[Response, ...] = ()
    two_way_course: ProfileResponse | None = None
    loop_gain: float = float("nan")
    levels: dict[str, LevelCurve] = field(default_factory=dict)
    two_way_curves: dict[str, LevelCurve] = field(default_factory=dict)
    two_way_levels: dict[str, tuple[int, float]] = field(default_factory=dict)
    standings: tuple[Standing, ...] = ()
    deciding: dict[str, LevelCurve] = field(default_factory=dict)
    avoid: dict[str, tuple[tuple[float, float], ...]] = field(default_factory=dict)

    @property
    def order_map(self) -> OrderMap:
        """Torque lines over the rate, N m."""
        orders = np.unique(np.concatenate([response.state.step_orders for response in self.responses]))
        lines = np.full((len(self.responses), orders.size), np.nan, dtype=np.complex128)
        for row, response in enumerate(self.responses):
            lines[row, np.searchsorted(orders, response.state.step_orders)] = response.state.lines
        return OrderMap(self.mode.rates, orders, lines)

    def differing_states(self, k: int) -> tuple[Response, ...]:
        """Return the steady states at rate k whose RMS is outside the 95 % interval of the worst one's.

        The RMS includes the non-repeating part; the interval is that of the lines, shifted by that part.
        """
        worst = self.responses[k]
        low, high = self.rms_band[k].T + (worst.whole_rms() - worst.rms())
        others = [(response, response.whole_rms()) for response in self.states[k] if response is not worst]
        return tuple(response for response, rms in others if np.any((rms < low) | (rms > high)))

    def two_way_lines(self, k: int) -> tuple[ComplexArray, ComplexArray]:
        """Return torque (n,) and line of sight (n, m) of the two-way lines at rate k, NaN for a missing line.

        They correspond to the one-way lines' frequencies.
        """
        one, two = self.responses[k], self.two_way[k]
        torque = np.full(one.state.lines.size, np.nan, dtype=np.complex128)
        sight = np.full(one.phasors.shape, np.nan, dtype=np.complex128)
        # A motion of several periods has lines between those of the other coupling: orders are matched, not positions.
        _, here, there = np.intersect1d(one.state.step_orders, two.state.step_orders, return_indices=True)
        torque[here], sight[here] = two.state.lines[there], two.phasors[there]
        return torque, sight

    def worst_for(self, requirement: Requirement) -> LineOfSight:
        """Return the response at the rate of a requirement's largest level, or a profile's course."""
        if self.course is not None:
            return self.course
        curve = self.levels[requirement.name]
        return curve.at[int(curve.level.argmax())]

    def two_way_worst_for(self, requirement: Requirement) -> LineOfSight | None:
        """Return the two-way response at that rate; None without two-way responses."""
        if self.two_way_course is not None:
            return self.two_way_course
        return self.two_way[self.two_way_levels[requirement.name][0]] if self.two_way else None
