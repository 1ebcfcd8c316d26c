"""Settings of the stages of an identification: growth, joint fit, confirmation, release."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class StageSettings:
    """Limits of the stages, each with its origin."""

    first_escapes: int = 8
    """Escapes of the best start: 35 of 36 complete campaigns need at most one, the other four."""
    most_cliffs: int = 3
    """Times that a fit continues along a threshold: four of 100 random mechanisms end at one (make recovery)."""
    lowered: float = 0.3
    """Restart of the lower of two corner parameters, as a share of the upper one. From starts of 0.06 to 45 rad/s next
    to the corner, 2 of 7 came back without this rule, 7 of 7 with it."""
    spread: tuple[float, ...] = (1.0, 4.0, 0.25)
    """Factors on the file's value for the restart of a parameter that no record determines; measured with `lowered`."""
    repetitions: int = 2
    """Repetitions of filter and fit: a resonance in the noise with poles of radius 0.99 needs them."""
    longest_step_s: float = 2e-4
    """Largest integration step that is stable even if a start's viscous friction is far too large."""
    exchange_margin: float = 0.01
    """Largest relative loss at which a term in place of a needed one is still tried by a fit: the derivatives at the
    optimum of all terms do not separate a detent of 7.2 deg from offsets of the phase voltages, of which a fit
    leaves 1 % more of the sum of squares."""
    alike: float = 2.0
    """Difference of the Bayesian criterion below which one set of terms is no better than another (Raftery 1995)."""
    padded: int = 8
    """Zero padding of the spectrum of a misfit, so that a line between two bins stands out as one on a bin does."""
    most_switches: int = 100_000
    """Switches that are logged near the point where a model leaves a record; the paper's sweep of 60 s has 142."""

    # Effects named by the first moments; a prototype with these followed 16 of 16 benches of another generator.

    prunable: float = 1.5
    """Largest robust cost per sample of the first moments, in sigmas squared, at which unneeded effects are dropped: a
    larger misfit does not show which are needed."""
    surely_explained: float = 1.04
    """Robust cost per sample of the first moments, in sigmas squared, below which laws are not tried: friction that
    rises with the load left 1.01, five single effects in its place 1.09 each."""
    law_escapes: int = 2
    """Escapes of the growth of a law that explains the first moments."""
    small_escapes: int = 1
    """Escapes of a growth with few effects free: mostly another effect stalls it."""
    small_leaps: int = 4
    """Leaps and retreats of a growth with few effects free."""
    plain_leaps: int = 2
    """Leaps and retreats of the growth of the mechanism as written."""
    at_edge: float = 2.0
    """Deviation from its small prior, in standard deviations, at which a term or a record's own value counts as at its
    edge."""
    wider: float = 4.0
    """Factor by which that prior is widened then."""
    masked_left: float = 1.05
    """Largest residual-to-noise ratio at which masked moments end the search: a larger one shows that something else is
    missing. A floor is known to 2 or 3 %; a bench that lacks a high-pass of 0.6 s was followed with one mask and
    left 1.09."""
    delays_help: float = 0.5
    """Share of the misfit of the mechanism as written below which that with delays of the records counts as small: then
    the laws that a delay imitates are tried first."""
    law_coulomb: float = 0.3
    """Additional start of a law of friction: Coulomb friction as a share of static friction."""
    other_starts: int = 5
    """Drawn starts from which hum is projected out if the best one does not suffice."""
    growable: float = 2.5
    """Robust cost per sample of the first moments below which a look is grown: 4 of 8 with 1.1 to 2.1 left reached the
    ends of all records, none of 6 with 2.7 to 5.7."""
    beside_worse: float = 2.0
    """Largest ratio of the misfits beyond noise of the best looks of both kinds, term and law, at which a second effect
    is also added to the worse one: load-dependent friction instead of a harmonic left 0.6 where the harmonic left
    0.5."""
    singles: int = 4
    """Single effects, the likeliest by their derivatives, that are refined on their own; as many terms of any number of
    periods."""
    unlisted_at_once: int = 4
    """Places of one plant for terms of any number of periods."""
    slow_at_once: int = 2
    """Places for friction over the angle of rotor or of output, if there is one: four of each cost 22 % of the time of
    a step, one of each 4 %."""
    slow_step: float = 1.1
    """Factor between consecutive numbers of periods in a scan of these: over a sweep of five rotor turns, geared down
    50 times, three periods a turn of the output to either side of 33 explain nearly as much."""
    slow_share: float = 0.3
    """Share of the best listed effect's score below which friction over the angle is skipped."""
    slow_alone: float = 3.0
    """Ratio to the best listed effect's score above which friction over the angle ends the search for other numbers of
    periods: it explained ten times as much where it was missing."""
    scan_s: float = 1.5
    """Total duration of the windows in which numbers of periods are scanned."""
    effect_scores_s: float = 2.0
    """Duration of each record over which effects are compared by derivatives alone, if all of it is followed."""
    effect_scan_s: float = 0.3
    """Part of it in which detents of any number of periods are scanned in steps: over a longer one a step would miss
    some."""
    grown_at_raised: int = 2
    """Effects with the highest scores at a raised noise level that are grown."""
    grown_share: float = 0.5
    """Share of the best one's score above which another one is grown."""
    scan_step: float = 1.03
    """Factor between consecutive numbers of periods in a scan: over the few degrees of the first moments a neighbour
    explains nearly as much."""
    period_stride: float = 0.02
    """First stride between neighbouring numbers of periods, as a share of the number."""
    past_stall: float = 1.5
    """Extent of the comparison of effects at a stalled growth, in horizons."""
    past_stall_s: float = 0.1
    """Least time past the horizon over which they are compared."""
    second_steps: int = 12
    """Robust steps of that comparison, which starts from the end of the growth."""
    alike_looks: float = 20.0
    """Difference of the Bayesian criterion below which several effects are grown: kinematic errors of orders 5 to 8
    left 1.02 each of the first moments."""
    nearly_followed: float = 0.9
    """Share of all samples above which a growth is assumed to lack no effect, only a leap or an escape."""
    look_further: float = 1.2
    """Factor by which a growth must be followed further after such a comparison, for effects to be compared once more.
    """
    left_of_excess: float = 0.1
    """Largest share of a model's misfit beyond noise that one more effect may leave to count as the explanation: with a
    clock of 90 ppm 0.11 of 1.6 were left, as the noise level of one record was 11 % too low, by delays 0.39."""
    clearly_more: float = 2.0
    """Factor by which a single effect must exceed the next one to be grown before others are tried."""
    second_looks: int = 3
    """Largest number of models grown after that comparison."""
    hum_helps: float = 0.5
    """Largest share of the misfit of the mechanism as written, beyond noise, that hum may leave to be grown: it left
    0.0 of 1.9 where the cause was hum, 0.6 of 0.14 where it was friction."""
    hum_further: float = 1.1
    """Factor by which a growth with hum must be followed further for its frequency to be determined once more."""
    complete_steps: int = 12
    """Steps over whole records, of growth and joint fits, of an identification whose mechanism is complete: with its
    multi-start 0.56 to 0.61e9 units of work were counted where 12 steps give 0.57 to 0.61e9."""
    effects_budget: int = 28
    """Multiple of that work after which no further effects are freed: 15 to 25 times the CPU time of such an
    identification, where a unit takes 9 ns, and 6 to 7 ns on the ladder."""
    ladder_budget: int = 100
    """Multiple of that work after which the ladder ends. Records that contradict one another, or a trigger that is 3 ms
    off, are reinterpreted after all other rungs: with 35 two of three tests ended before."""
    whole_records_budget: int = 6
    """Multiple of that work allowed for the comparison of effects over whole records that are followed to their ends:
    on a bench of a sweep of 40 s that lacked nothing this took 240 s where the identification took 31."""
    whole_steps: int = 6
    """Robust steps of a look at whole records, which starts at an optimum without the effect."""
    freed_steps: int = 5
    """Steps with more effects free, at the horizons reached, before those not needed are dropped."""

    # The others are choices; no benchmark distinguishes values near them.

    candidates: int = 12
    """Largest number of starts that are grown."""
    together: int = 4
    """Candidates that are grown at once on external workers; the first that follows all records counts."""
    further_escapes: int = 2
    """Escapes from a joint fit of the followed records alone."""
    much_further: float = 2.0
    """Factor on the followed share of the records that a raised noise level must achieve if it does not lead to their
    ends."""
    term_escapes: int = 3
    """Escapes of a growth with extra terms: one that stalls more often lacks an effect that none of them describes."""
    joint_steps: int = 30
    """Steps of a joint fit that shows which terms are needed, and only has to come near its optimum."""
    confirmations: int = 2
    """Attempts of growth with finer steps."""
    corner_share: float = 1e-3
    """Largest relative excess over its lower limit, another parameter, at which a parameter is in the corner."""
    back_from_edge: float = 4.0
    """Cost in sigmas squared that is accepted to move away from a cliff."""
    share_of_time: float = 0.05
    """Share of the search's time that the residual-to-noise check may take."""
    rough_tolerance: float = 1e-6
    """Relative fall of the cost at which the fit before the release of the noise may stop."""
    most_from_draws: int = 3
    """Times that a search continues from a draw with a lower cost than its optimum."""
    near_tolerance: float = 1e-4
    """Relative fall of the cost at which the fit of all terms may stop before they are judged."""
    held_share: float = 1e-4
    """Width, as a share of its small prior's, within which a dropped term is held at zero while the others are fitted.
    """
    exchanges: int = 3
    """Largest number of terms that are tried in place of others, those that explain most."""
    most_named: int = 3
    """Largest number of added terms that a sentence names, those that explain most."""
    stretch_steps: float = 16.0
    """Full steps before and after the instant over which the misfit's frequency is determined: four electrical turns
    each."""
    stands_out: float = 3.0
    """Least ratio of a misfit line's amplitude to the median of the amplitudes around it."""
    line_share: float = 0.2
    """Least amplitude of such a line, as a share of the largest, of which a smaller one may be a side lobe."""


STAGES = StageSettings()
