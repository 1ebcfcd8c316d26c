"""Rules by which missing effects are looked for, kept and named; one value during a fit, one in a diagnosis."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from mechid.parameter import Role


@dataclass(frozen=True, kw_only=True)
class EffectRules:
    """Limits of a search for missing effects.

    A share is that of the misfit: of what the records hold beyond their noise and the effects found so far. Where a
    line does not say what fixed a limit, it is a choice.
    """

    # One effect more, one less, in either search.

    least_chi_square: float = 30.0
    """From which an effect counts, whatever its freedom: by chance, one in 2e7 of one degree of freedom."""
    false_discoveries: float = 0.05
    """Rate at which the score test may ask for an effect by chance; 1 is no limit. The usual rate (Benjamini and
    Hochberg 1995); 40 of 40 complete benches were left without a name (docs/diagnosis.md)."""
    share: float = 0.1
    """Least share that a further effect explains in a fit."""
    share_of_score: float = 0.1
    """Least share by the score test alone."""
    share_to_stay: float = 0.0
    """Least share of an effect that is there already."""
    least_deviation: float = 0.0
    """Standard errors, widened for model error, by which one of its parameters is off its null value."""
    tries: int = 2
    """Effects that are fitted where the likeliest does not keep in a fit what its score promised."""
    tolerance: float = 0.1
    """Chi-square by which a step has to better a fit for another one to follow: no effect is judged by so little."""

    # Fits of a diagnosis.

    most: int = 16
    """Effects of a model."""
    periods_around: int = 1
    """Periods in a turn by which what is seen may be wrong: a record of few turns does not tell them better."""
    escapes: int = 1
    """Of a growth of what a joint fit leaves beyond noise."""
    steps: int = 30
    """Of a fit at most."""
    finer: float = 3.0
    """Times as many effective samples after a fit as it was stopped by, from which it goes on."""
    followed: float = 1.01
    """Residual-to-noise ratio from which a model is grown anew: more than a level known to 1 % explains."""
    law_tries: int = 2
    """Laws that are fitted with what may be beside them."""
    law_steps: int = 8
    """Steps in which a law has to show that it takes a share. With it hysteresis of a gear took 135 s of CPU, 297
    before (docs/diagnosis.md, with other savings)."""

    # What is named in the end.

    mostly: float = 0.5
    """Least share to be named where more than noise is left, or of a law to be tried with further effects where it
    alone is not the best. Six of the eight effects that a saturating torque constant was called take less
    (docs/diagnosis.md)."""
    few: int = 4
    """Effects that a mechanism file may well lack at once."""
    few_weak: int = 2
    """Of them that may take less than `mostly`: small ones do, since the noise is not known to the last digit."""
    nearly_all: float = 0.9
    """Share from which an effect is named where the parts of the records disagree on the values: what a block of the
    library is takes nearly all, whatever is missing beside it."""
    small: float = 0.01
    """Of the largest chi-square, below which an effect of records followed in part is not named. Beside backlash and a
    detent, delays of 1 to 6 us were named before this rule (docs/diagnosis.md)."""
    far: float = 1.2
    """Residual-to-noise ratio, with all effects found, from which a model may stand on a wrong branch: that of a
    record's misfit, too."""
    suggested: int = 3
    """Effects that the residual of a fit suggests at most."""

    # Effects found as far as records are followed.

    first_escapes: int = 1
    """Of a growth before anything is asked for: what is missing stops it again."""
    patient_escapes: int = 8
    """Of a growth of a model that leaves no more than noise as far as it follows: then a branch stops it."""
    rounds: int = 12
    """Of growth and a further effect at most."""
    lowered: int = 4
    """Times that one growth lowers noise levels at most. Levels of benches with backlash stood 1.2 to 2 times too high
    (docs/diagnosis.md)."""
    enough: float = 0.3
    """Share of the records from which on effects are named: in less of them many imitate one another."""
    further: float = 1.05
    """Times as much of the records as before, from which a round has led further, unless it has led to their ends."""


IN_DIAGNOSIS = EffectRules()
DURING_FIT = replace(
    IN_DIAGNOSIS,
    false_discoveries=1.0,
    share=0.5,  # with less, voltages were named for phases apart, temperatures for a harmonic (docs/identification.md)
    share_of_score=0.0,
    share_to_stay=0.5,
    least_deviation=4.0,  # without it voltages were named for hysteresis in the gear (docs/identification.md)
    tolerance=1e-6,  # here a relative fall of the cost
    tries=1,
)


@dataclass(frozen=True, kw_only=True)
class DisturbancePriors:
    """How far records may be from the mechanism as written, as standard deviations of priors."""

    clock_ppm: float = 300.0
    """Of two ordinary clocks: quartz oscillators are within 100 ppm, a driver's ceramic resonator within 5000."""
    delay_s: float = 3e-4
    """How late a record's command may be: that of a trigger anywhere within a bus cycle of 1 ms."""
    shares: Mapping[Role, float] = field(
        default_factory=lambda: {Role.SUPPLY: 0.02, Role.WINDING_RESISTANCE: 0.04, Role.TRANSDUCER_GAIN: 0.03}
    )
    """Of values of single records, relative: 4 % of resistance are 10 K of copper; charge amplifiers and cables leave
    gains of a test stand 1 to 3 % apart. That of the supply is a choice."""
    reach: float = 5.0
    """Standard deviations to either bound. A choice."""
    widest_clock_ppm: float = 5000.0
    """Of a driver's ceramic resonator, to which a clock's prior may widen and its range reach."""
    widest_delay_s: float = 0.01
    """The same of a delay: ten bus cycles. A choice."""
    widest_shares: Mapping[Role, float] = field(
        default_factory=lambda: {Role.SUPPLY: 0.2, Role.WINDING_RESISTANCE: 0.4, Role.TRANSDUCER_GAIN: 0.2}
    )
    """The same of values of single records, relative: 40 % of resistance are 100 K of copper. The others are choices:
    a gain or a supply that is further off is a wrong entry of a file."""
    hum_at_rest: float = 100.0
    """Chi-square of hum in the rests of all records together from which it is there: by chance, with 6 degrees of
    freedom a record, once in 1e9 of six records."""
    rest_noise: float = 1.5
    """Variance of what is left of a rest beside hum, over that of the noise, up to which it is a rest."""
    hum_periods: float = 2.0
    """Periods of the grid that a rest holds at least. A choice."""
    hum_samples: int = 64
    """Samples from which lines of the mains are looked for. A choice."""


PRIORS = DisturbancePriors()
