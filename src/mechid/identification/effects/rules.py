"""Rules by which missing effects are looked for, kept and named; one value during a fit, one in a diagnosis."""

from __future__ import annotations

from dataclasses import dataclass, replace


@dataclass(frozen=True, kw_only=True)
class EffectRules:
    """Limits of a search for missing effects.

    A share is that of the misfit: of what the records hold beyond their noise and beyond the effects found so far.

    Attributes
    ----------
    least_chi_square : float
        From which an effect counts, whatever its freedom. By chance, one in 2e7 of one degree of freedom.
    false_discoveries : float
        Rate at which the score test may ask for an effect by chance (Benjamini and Hochberg 1995); 1 asks for no rate.
        The usual rate; 40 of 40 complete benches were left without a name (docs/diagnosis.md).
    share : float
        Least share that a further effect has to explain in a fit. During a fit 0.5: with less, voltages were named
        for phases apart and temperatures for a torque harmonic (docs/identification.md). In a diagnosis 0.1, a choice.
    share_of_score, share_to_stay : float
        Least share by the score test alone, and of an effect that is there already: what lower limits a fit asks for
        is no use to either in the other search.
    least_deviation : float
        Standard errors, widened for model error, by which one of its parameters has to be off its null value; 0 asks
        for none. Without it voltages were named for hysteresis in the gear (docs/identification.md).
    tolerance : float
        Relative fall of the cost at which a fit that tests an effect may stop; in a diagnosis it is the chi-square
        of a step, over the effective samples: no effect is judged by so little. Choices.
    tries : int
        Effects that are fitted where the likeliest does not keep in a fit what its score promised. A choice.
    most : int
        Effects of a model. A choice.
    periods_around : int
        Periods in a turn by which what is seen may be wrong: a record of few turns does not tell them better.
    escapes : int
        Of a growth of what a joint fit leaves beyond noise. A choice.
    steps : int
        Of a fit at most. A choice.
    finer : float
        Times as many effective samples after a fit as it was stopped by, from which it goes on. A choice.
    followed : float
        Residual-to-noise ratio from which a model is grown anew: more than a level known to 1 % explains.
    law_tries : int
        Laws that are fitted with what may be beside them. A choice.
    law_steps : int
        Steps in which a law has to show that it takes a share. With it hysteresis of a gear took 135 s of CPU,
        297 before (docs/diagnosis.md, with other savings).
    mostly : float
        Least share of an effect to be named where more than noise is left, or of a law to be tried with further
        effects where it alone is not the best. Six of the eight effects that a saturating torque constant was called
        take less (docs/diagnosis.md).
    few, few_weak : int
        Effects that a mechanism file may well lack at once, a choice; and how many of them may take less than `mostly`:
        small ones do, since the noise is not known to the last digit.
    nearly_all : float
        Share, of what a model without it leaves, from which an effect is named where the parts of the records still
        disagree on the values: what a block of the library is takes nearly all, whatever is missing beside it. A
        choice.
    small : float
        Of the chi-square of the effect that explains most, below which another is not named of records followed in
        part. Backlash and a detent: beside them, delays of 1 to 6 us were named before this rule (docs/diagnosis.md).
    far : float
        Residual-to-noise ratio with all effects found from which a model may stand on a wrong branch: the limit from
        which a record counts as misfit, too.
    first_escapes, patient_escapes : int
        Of a growth before anything is asked for, since what is missing stops it again; and of a model that leaves no
        more than noise as far as it follows, which a branch stops. The second is a choice.
    rounds : int
        Of growth and a further effect at most. A choice.
    lowered : int
        Times that noise levels are lowered by one growth at most. Levels of benches with backlash stood 1.2 to 2 times
        too high (docs/diagnosis.md).
    enough : float
        Share of the records from which on effects are named: in less of them many imitate one another. A choice.
    further : float
        Times as much of the records as before, from which a round has led further, unless it has led to their ends. A
        choice.
    suggested : int
        Effects that a fit's residual suggests at most. A choice.
    """

    least_chi_square: float = 30.0
    false_discoveries: float = 0.05
    share: float = 0.1
    share_of_score: float = 0.1
    share_to_stay: float = 0.0
    least_deviation: float = 0.0
    tolerance: float = 0.1
    tries: int = 2
    most: int = 16
    periods_around: int = 1
    escapes: int = 1
    steps: int = 30
    finer: float = 3.0
    followed: float = 1.01
    law_tries: int = 2
    law_steps: int = 8
    mostly: float = 0.5
    few: int = 4
    few_weak: int = 2
    nearly_all: float = 0.9
    small: float = 0.01
    far: float = 1.2
    first_escapes: int = 1
    patient_escapes: int = 8
    rounds: int = 12
    lowered: int = 4
    enough: float = 0.3
    further: float = 1.05
    suggested: int = 3


IN_DIAGNOSIS = EffectRules()
DURING_FIT = replace(
    IN_DIAGNOSIS,
    false_discoveries=1.0,
    share=0.5,
    share_of_score=0.0,
    share_to_stay=0.5,
    least_deviation=4.0,
    tolerance=1e-6,
    tries=1,
)
