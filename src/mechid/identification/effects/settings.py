"""Rules for the selection and naming of missing effects: one set during a fit, one in a diagnosis."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from mechid.parameter import Role


@dataclass(frozen=True, kw_only=True)
class EffectRules:
    """Limits of a search for missing effects.

    A share refers to the misfit: the residual beyond noise and the effects found so far. A limit without a stated
    origin is a choice.
    """

    # One effect more, one less, in either search.

    least_chi_square: float = 30.0
    """Least chi-square of an effect with any number of degrees of freedom: by chance, one in 2e7 for one degree."""
    false_discoveries: float = 0.05
    """Rate at which the score test may support an effect by chance; 1 is no limit. The usual rate (Benjamini and
    Hochberg 1995); 40 of 40 complete benches were left without a name (docs/diagnosis.md)."""
    share: float = 0.1
    """Least share that a further effect explains in a fit."""
    share_of_score: float = 0.1
    """Least share by the score test alone."""
    share_to_stay: float = 0.0
    """Least share of an effect that is already in the model."""
    least_deviation: float = 0.0
    """Least deviation of one of its parameters from its null value, in standard errors widened for model error."""
    tries: int = 2
    """Effects that are fitted if the likeliest does not confirm its score in a fit."""
    tolerance: float = 0.1
    """Least improvement of chi-square by a step for another one to follow: no effect is judged by so little."""

    # Fits of a diagnosis.

    most: int = 16
    """Largest number of effects of a model."""
    periods_around: int = 1
    """Possible error of a determined number of periods in a turn: a record of few turns does not determine it better.
    """
    escapes: int = 1
    """Escapes of a growth, if a joint fit leaves more than noise."""
    steps: int = 30
    """Largest number of steps of a fit."""
    finer: float = 3.0
    """Factor by which the effective samples must grow during a fit for it to continue."""
    noise_limit: float = 1.01
    """Residual-to-noise ratio above which a model is grown again: more than a level known to 1 % explains."""
    law_tries: int = 2
    """Laws that are fitted together with further effects."""
    law_steps: int = 8
    """Steps in which a law must show that it explains a share. With it hysteresis of a gear took 135 s of CPU, 297
    before (docs/diagnosis.md, with other savings)."""

    # What is named in the end.

    mostly: float = 0.5
    """Least share for an effect to be named if more than noise is left, or for a law to be tried with further effects
    if it alone is not the best. Six of the eight effects that were named for a saturating torque constant explain
    less (docs/diagnosis.md)."""
    few: int = 4
    """Number of effects that a mechanism file may plausibly lack at once."""
    few_weak: int = 2
    """Number of them that may explain less than `mostly`: small ones do, since the noise is not known exactly."""
    nearly_all: float = 0.9
    """Share above which an effect is named although parts of the records disagree on the values: the right block of the
    library explains nearly all, even if other effects are missing too."""
    small: float = 0.01
    """Share of the largest chi-square below which an effect of partly followed records is not named. In addition to
    backlash and a detent, delays of 1 to 6 us were named before this rule (docs/diagnosis.md)."""
    far: float = 1.2
    """Residual-to-noise ratio, with all effects found, above which a model may be on a wrong branch; also that of a
    record's misfit."""
    suggested: int = 3
    """Largest number of effects that the residual of a fit suggests."""

    # Effects found as far as records are followed.

    first_escapes: int = 1
    """Escapes of a growth before any effect is added: a missing effect stops it again."""
    patient_escapes: int = 8
    """Escapes of a growth whose model leaves no more than noise as far as it follows: then a wrong branch stops it."""
    rounds: int = 12
    """Largest number of rounds of growth and a further effect."""
    lowered: int = 4
    """Largest number of times that one growth lowers noise levels. Levels of benches with backlash were 1.2 to 2 times
    too high (docs/diagnosis.md)."""
    enough: float = 0.3
    """Followed share of the records above which effects are named: in a smaller share many imitate one another."""
    further: float = 1.05
    """Factor by which a round must increase the followed share of the records, unless it reaches their ends."""


IN_DIAGNOSIS = EffectRules()
DURING_FIT = replace(
    IN_DIAGNOSIS,
    false_discoveries=1.0,
    # With less, voltages were named for unequal phases, temperatures for a harmonic (docs/identification.md).
    share=0.5,
    share_of_score=0.0,
    share_to_stay=0.5,
    # Without it, voltages were named for hysteresis in the gear (docs/identification.md).
    least_deviation=4.0,
    # Fits of a search stop by a relative reduction of the cost, not by chi-square.
    tolerance=1e-6,
    tries=1,
)


@dataclass(frozen=True, kw_only=True)
class DisturbancePriors:
    """Deviations of records from the mechanism as written, as standard deviations of priors."""

    clock_ppm: float = 300.0
    """Difference of two ordinary clocks: quartz oscillators are within 100 ppm, a driver's ceramic resonator within
    5000."""
    delay_s: float = 3e-4
    """Delay of a record's command: that of a trigger anywhere within a bus cycle of 1 ms."""
    shares: Mapping[Role, float] = field(
        default_factory=lambda: {Role.SUPPLY: 0.02, Role.WINDING_RESISTANCE: 0.04, Role.TRANSDUCER_GAIN: 0.03}
    )
    """Relative deviation of per-record values: 4 % of resistance are 10 K of copper; charge amplifiers and cables leave
    gains of a test stand 1 to 3 % apart. That of the supply is a choice."""
    reach: float = 5.0
    """Standard deviations to either bound. A choice."""
    widest_clock_ppm: float = 5000.0
    """Widest prior and range of a clock: those of a driver's ceramic resonator."""
    widest_delay_s: float = 0.01
    """Widest prior and range of a delay: ten bus cycles. A choice."""
    widest_shares: Mapping[Role, float] = field(
        default_factory=lambda: {Role.SUPPLY: 0.2, Role.WINDING_RESISTANCE: 0.4, Role.TRANSDUCER_GAIN: 0.2}
    )
    """Widest prior and range of per-record values, relative: 40 % of resistance are 100 K of copper. The others are
    choices: a larger deviation of a gain or a supply is a wrong entry of a file."""
    hum_at_rest: float = 100.0
    """Chi-square of hum in the rests of all records together above which it counts as present: by chance, with 6
    degrees of freedom a record, once in 1e9 of six records."""
    rest_noise: float = 1.5
    """Largest variance of a rest's residual besides hum, in variances of the noise."""
    hum_periods: float = 2.0
    """Least number of grid periods in a rest. A choice."""
    hum_samples: int = 64
    """Least number of samples for mains lines to be determined. A choice."""


PRIORS = DisturbancePriors()
