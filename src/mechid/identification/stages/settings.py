"""Settings of the stages of an identification: growth, joint fit, confirmation, release."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class StageSettings:
    """Limits of the stages, each with what fixed it."""

    first_escapes: int = 8
    """Escapes of the best start: 35 of 36 complete campaigns need one at most, the other four."""
    most_cliffs: int = 3
    """Times that a fit continues along a threshold: four of 100 random mechanisms end at one (make recovery)."""
    lowered: float = 0.3
    """Share of the upper of two corner parameters where the lower one begins again. From starts of 0.06 to 45 rad/s
    beside the corner, 2 of 7 came back without this rule, 7 of 7 with it."""
    spread: tuple[float, ...] = (1.0, 4.0, 0.25)
    """Factors on the file's value where a parameter that no record sees begins again; measured with `lowered`."""
    repetitions: int = 2
    """Repetitions of filter and fit: a resonance in the noise with poles of radius 0.99 needs them."""
    longest_step_s: float = 2e-4
    """Integration steps up to this length are stable also where a start's viscous friction is far too large."""

    as_good: float = 0.01
    """Share of what a needed term explains by which another one in its place may be worse, by the derivatives at the
    optimum of all terms, and still be tried by a fit: they do not tell a detent of 7.2 deg from offsets of the phase
    voltages, which a fit from a bad start left 1.4 % apart."""
    alike: float = 2.0
    """Difference of the Bayesian criterion below which one set of terms is no better than another (Raftery 1995)."""

    # The others are choices; no benchmark distinguishes values near them.

    candidates: int = 12
    """Starts that are grown at most."""
    together: int = 4
    """Candidates that are grown at once where workers do the work; the first that follows all records counts."""
    further_escapes: int = 2
    """Escapes from where the records that it follows have their values by themselves."""
    much_further: float = 2.0
    """Factor on the share of the records that has to be followed at a raised noise level which does not follow them to
    their ends."""
    term_escapes: int = 3
    """Escapes of a growth with extra terms: one that stalls more often lacks something that none of them holds."""
    narrower: float = 20.0
    """Factor by which the small prior of a term is narrower once it is not needed inside the gates."""
    alternatives: int = 3
    """Alternative laws that do not explain the first moments and are grown all the same: those with the best starts."""
    joint_steps: int = 30
    """Steps of the joint fits that show which disturbances and terms are needed."""
    near_all_terms: float = 1e-4
    """Relative fall of the cost at which the fit of all terms may stop before they are judged."""
    held_share: float = 1e-4
    """Share of its small prior's width within which a dropped term is held about nothing while others are fitted."""
    exchanges: int = 3
    """Terms tried in place of others at most, those that explain most."""
    confirmations: int = 2
    """Times that growth in finer steps is tried."""
    corner_share: float = 1e-3
    """Relative excess over a parameter that it never lies below, up to which a parameter is in the corner."""
    back_from_edge: float = 4.0
    """Sigmas squared that it may cost to stand clear of a cliff."""
    share_of_time: float = 0.05
    """Share of the search's time that the residual-to-noise check may take."""
    rough_tolerance: float = 1e-6
    """Relative fall of the cost at which the fit before the release of the noise may stop."""
    most_from_draws: int = 3
    """Times that a search continues from a draw that is lower than its optimum."""


STAGES = StageSettings()
