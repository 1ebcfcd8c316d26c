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
    exchange_margin: float = 0.01
    """Share of what a needed term explains by which another one in its place may be worse and still be tried by a fit:
    the derivatives at the optimum of all terms do not separate a detent of 7.2 deg from offsets of the phase voltages,
    of which a fit leaves 1 % more of the sum of squares."""
    alike: float = 2.0
    """Difference of the Bayesian criterion below which one set of terms is no better than another (Raftery 1995)."""
    padded: int = 8
    """Zero padding of the spectrum of a misfit, so that a line between two bins stands out as one on a bin does."""
    most_switches: int = 100_000
    """Switches that are logged where a model leaves a record; the paper's sweep of 60 s has 142."""

    # Effects named by the first moments; a prototype with these followed 16 of 16 benches of another generator.

    prunable: float = 1.5
    """Robust cost a sample of the first moments, in sigmas squared, up to which effects that are not needed there are
    dropped: what leaves more of them does not say which are."""
    surely_explained: float = 1.04
    """Robust cost a sample of the first moments, in sigmas squared, below which laws are not looked at: friction that
    rises with the load left 1.01, five single effects in its place 1.09 each."""
    law_escapes: int = 2
    """Escapes of the growth of a law that explains the first moments."""
    small_escapes: int = 1
    """Escapes of a growth with few effects free: what stalls it is mostly another effect."""
    small_leaps: int = 4
    """Leaps and retreats of a growth with few effects free."""
    plain_leaps: int = 2
    """Leaps and retreats of the growth of the mechanism as written."""
    at_edge: float = 2.0
    """Standard deviations of its small prior from which a term, or a record's own value, stands at the edge of it."""
    wider: float = 4.0
    """Factor by which that prior is then wider."""
    masked_left: float = 1.05
    """Residual-to-noise ratio up to which masked moments end the search: with more left the model lacks something else.
    A floor is known to 2 or 3 %; a bench that lacks a high-pass of 0.6 s was followed with one mask and left 1.09."""
    delays_help: float = 0.5
    """Share of what the mechanism as written leaves of the first moments below which delays of the records do: then
    the laws that a delay imitates are tried first."""
    law_coulomb: float = 0.3
    """Coulomb friction over static friction where a law of friction begins too."""
    other_starts: int = 5
    """Drawn starts from which hum is projected out where the best one does not do."""
    growable: float = 2.5
    """Robust cost a sample of the first moments below which a look is grown: 4 of 8 with 1.1 to 2.1 left came to the
    ends of all records, none of 6 with 2.7 to 5.7."""
    beside_worse: float = 2.0
    """Times what the best look leaves beyond noise that one of the other kind, term or law, may leave to have one more
    effect compared beside it: of load-dependent friction and a harmonic it left 0.6 where the harmonic left 0.5."""
    singles: int = 4
    """Single effects, those likeliest by their derivatives, that are refined by themselves; as many terms of any number
    of periods."""
    unlisted_at_once: int = 4
    """Terms of any number of periods that one plant has places for."""
    slow_at_once: int = 2
    """The same of frictions over the angle of rotor or of output, where there is one: four of each cost 22 % of the
    time of a step, one of each 4 %."""
    slow_step: float = 1.1
    """Factor from one number of periods of these to the next that is looked at: over a sweep of five rotor turns,
    geared down 50 times, three periods a turn of the output to either side of 33 explain nearly as much."""
    slow_share: float = 0.3
    """Share of what the best listed effect explains up to which friction over the angle is passed over."""
    slow_alone: float = 3.0
    """Times what the best listed effect explains from which friction over the angle leaves no other number of periods
    to be looked at: it explained ten times as much where it was missing."""
    scan_s: float = 1.5
    """Time of all windows together in which numbers of periods are gone through."""
    effect_scores_s: float = 2.0
    """Time of each record over which effects are compared by their derivatives alone, where all of it is followed."""
    effect_scan_s: float = 0.3
    """Of which detents of any number of periods are gone through in steps: over longer ones a step would miss some."""
    grown_at_raised: int = 2
    """Effects that are grown of those which explain most at a raised noise level."""
    grown_share: float = 0.5
    """Share of what the best of them explains, from which another one is grown."""
    scan_step: float = 1.03
    """Factor from one number of periods to the next that is looked at: over the few degrees of the first moments a
    neighbour explains nearly as much."""
    period_stride: float = 0.02
    """Share of the number of periods in a turn by which its neighbours are first looked at."""
    past_stall: float = 1.5
    """Times the horizon up to which effects are compared where a growth has stalled."""
    past_stall_s: float = 0.1
    """Time past the horizon up to which they are compared at least."""
    second_steps: int = 12
    """Robust steps of that comparison: they begin where the growth has ended."""
    alike_looks: float = 20.0
    """Difference of the Bayesian criterion up to which effects are all grown: kinematic errors of orders 5 to 8 left
    1.02 each of the first moments."""
    nearly_followed: float = 0.9
    """Share of all samples from which a growth is taken to lack no effect but a leap or an escape."""
    look_further: float = 1.2
    """Times as far that a growth has to come after such a comparison, to have effects compared once more."""
    left_of_excess: float = 0.1
    """Share of what a model leaves beyond noise that one more effect may leave of it, and explains it still: with a
    clock of 90 ppm 0.11 of 1.6 were left, as the noise level of one record was 11 % too low, by delays 0.39."""
    clearly_more: float = 2.0
    """Times as much as the next that a single effect has to explain to be grown before others are looked at."""
    second_looks: int = 3
    """Models that are grown after it at most."""
    hum_helps: float = 0.5
    """Share of what the mechanism as written leaves of the first moments beyond noise that hum has to leave at most to
    be grown: 0.0 of 1.9 where it was hum, 0.6 of 0.14 where it was friction."""
    hum_further: float = 1.1
    """Times as far that a growth with hum has to come after its frequency was read again, to have it read once more."""
    complete_steps: int = 12
    """Steps over whole records, of growth and joint fits, that an identification takes whose mechanism lacks nothing:
    with its multi-start 0.56 to 0.61e9 units of work were counted where 12 steps give 0.57 to 0.61e9."""
    effects_budget: int = 28
    """Times that work after which no further effects are freed: 15 to 25 times the CPU time of such an identification,
    of which a unit takes 9 ns there, 6 to 7 ns on the ladder."""
    ladder_budget: int = 100
    """Times that work after which the ladder ends. Records that contradict one another, or a trigger that is 3 ms off,
    are read as they were behind all that: with 35 times two of three tests ended before."""
    whole_records_budget: int = 6
    """Times that work that effects are compared for over whole records which are followed to their ends: on a bench of
    a sweep of 40 s that lacked nothing this took 240 s where the identification took 31."""
    whole_steps: int = 6
    """Robust steps of a look at whole records: they begin at an optimum without the effect."""
    freed_steps: int = 5
    """Steps with more effects free, at the horizons reached, before those not needed are dropped."""

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
    joint_steps: int = 30
    """Steps of a joint fit that shows which terms are needed, and only has to come near its optimum."""
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
    near_tolerance: float = 1e-4
    """Relative fall of the cost at which the fit of all terms may stop before they are judged."""
    held_share: float = 1e-4
    """Share of its small prior's width within which a dropped term is held about zero while the others are fitted."""
    exchanges: int = 3
    """Terms that are tried in place of others at most, those that explain most."""
    most_named: int = 3
    """Added terms that a sentence names at most, those that explain most."""
    stretch_steps: float = 16.0
    """Full steps before and after the instant over which the misfit's frequency is read: four electrical turns each."""
    stands_out: float = 3.0
    """Amplitude of a line of the misfit over the median of the amplitudes around it."""
    line_share: float = 0.2
    """Least amplitude of such a line over the largest, as it may be the side lobe of that one."""


STAGES = StageSettings()
