"""Thresholds for reports of wrong declarations, each with the origin of its value.

"Clean campaigns" are those of benchmarks/first_sight.py, which have no fault: a report about one is a false alarm.
"""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class ReadingRules:
    """Thresholds of the detectors, of the short search and of the comparison between records."""

    # Spectra of the first steps, measured and simulated (spectrum.py)
    coarse_microsteps: int = 2  # full and half steps fill a spectrum with lines, finer ones do not; not measured
    look_steps: float = 8.0  # full steps that are simulated; keeps the look at a campaign near 0.3 s of CPU
    least_look_s: float = 0.25  # their shortest duration, and
    longest_look_s: float = 2.0  # their longest; both fixed by the same 0.3 s
    piece_s: float = 0.5  # pieces of a varying rate, whose lines move; not varied
    highest_hz: float = 1000.0  # upper end of the compared band; not measured
    low_pass_order: int = 4  # of the assumed low-pass, |H|^2 = 1/(1 + (f/f_c)^(2 n)); not measured
    own_lines_s: float = 4.0  # length that is read for the record's own rate, at a constant rate; not measured
    own_ridge_s: float = 8.0  # the same at a varying rate; not measured
    same_rate: float = 0.01  # relative distance up to which two rates are the same; not measured
    same_end_rate: float = 0.1  # the same for the end of a sweep; not measured
    repeats: tuple[float, ...] = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0)  # steps after which a motor may repeat itself (theory)
    full_step_lines: tuple[float, ...] = (1.0, 2.0)  # multiples of the rate in lines of full steps (theory)
    rate_multiples: tuple[float, ...] = (1.0, 2.0, 4.0)  # multiples of a line that a rate may be (theory)
    least_rate_hz: float = 64.0  # lowest sample rate whose spectra tell anything; not measured
    least_samples: int = 32  # fewest samples for the same reason; not measured

    # Suspicions by spectral distance (suspicion.py); none in 112 clean campaigns with these factors
    box_points: int = 16  # 8 points gave a false swap in 1 of 37 clean campaigns, 16 none
    best_points: int = 4  # box points at which other readings are simulated; saves time only
    torque_scales: tuple[float, ...] = (1e-3, 1e-2, 1e2, 1e3)  # mN m and N cm for N m, and the reverse
    cut_offs_hz: tuple[float, ...] = (30.0, 50.0, 70.0, 100.0, 140.0, 200.0, 280.0, 400.0, 560.0)  # grid; not measured
    tried_microsteps: int = 16  # stands for all microsteps: their number changes little in this band; not measured
    nearer_ratio: float = 1.2  # distance as declared over that of another rate, a swap or a unit of all records
    stepping_ratio: float = 1.15  # the same for another stepping; also the margin of a swap over single causes
    much_nearer_ratio: float = 2.5  # the same for one record's unit (1.2 was wrong without detents) and a low-pass

    # Short search over the first steps (trial.py)
    trial_points: int = 512  # box points of a trial; 0.4 s of CPU a record
    trial_starts: int = 6  # refined points; with 4, one of 12 right records stayed at 84 sigma^2 a sample
    trial_steps: int = 24  # robust steps a start; as in the multi-start
    trial_s: float = 1.0  # longest stretch, which bounds the time at slow rates; not measured
    trial_records: int = 3  # records in a trial of several; not measured
    follows_share: float = 0.25  # of a resting model's cost; right readings: 0.20 at most, misread files: 0.26 and up
    trial_gain: float = 1.5  # cost as declared over that of a remedy; right ones: 4.2, without a detent 1.5
    unit_factor: float = 3.0  # distance of a usual unit from the suggested scale: spectra tell hundreds from thousands

    # Clocks, triggers and lost rows (timing.py)
    most_clock_error: float = 0.05  # largest relative rate error that is read from a record's own lines
    least_clock_error: float = 2e-3  # smallest one; no false alarm in 60 campaigns of the recovery benchmark
    clock_sigmas: float = 8.0  # standard errors of that rate; fixed together with the two above
    same_clock: float = 5e-4  # spread of the errors that have one cause, the recorder's clock; not measured
    rest_s: float = 1e-3  # beginning of a record that counts as its rest, and smoothing length; not varied
    moves_sigmas: float = 10.0  # deviation from the rest that is motion; not varied
    moves_share: float = 0.1  # and its share of half the swing, between the next two quantiles; not varied
    swing_quantiles: tuple[float, float] = (0.01, 0.99)  # a few samples that stand for missing ones are no swing
    same_period: float = 0.97  # correlation of two periods of a steady motion; not varied
    least_periods: int = 2  # steady periods on either side of a jump
    steady_share: float = 0.3  # spread within a side, as a share of the least jump; not varied
    least_jump_samples: float = 2.0  # smallest jump, samples
    least_jump_steps: float = 0.02  # smallest jump, full steps
    lost_step_margin: float = 0.1  # nearer to whole steps than this, the motor may have lost them
    sweep_orders: tuple[float, ...] = (0.5, 1.0)  # lines of a sweep over the step rate: those of the detents
    sweep_lag_turns: float = 3.0  # turns by which lines may lag in a right sweep; benches show 0.8 to 2.4
    sweep_lead_turns: float = 1.0  # turns by which they may lead
    sweep_reach: float = 0.05  # largest relative rate error that is looked for in a sweep
    sweep_clear: float = 100.0  # line power over the median around it
    sweep_nearer: float = 4.0  # line power over the most that a right sweep shows
    sweep_steps: int = 20_000  # most full steps that are read; bounds the time
    points_a_step: int = 8  # samples over a full step of travel; resolves both orders
    most_samples: int = 2_000_000  # most samples that are read: a record need not fit in memory
    kept_rest_s: float = 0.1  # rest that a proposed window keeps; not measured

    # Mains hum (hum.py)
    least_hum: float = 0.5  # amplitude over the noise level; `identify` removes smaller lines by itself
    skirt_bins: tuple[int, ...] = (3, 4, 5, 6)  # bins beside a line in which a resonance is still high
    narrow_share: float = 0.5  # highest share of the line there: hum of benches gave 0.23, resonances 0.8 to 1.1
    order_parts: int = 4  # lines at quarters of the step rate may be the motor's (theory)
    order_bins: float = 1.0  # bins within which a line is at such an order; not measured

    # Counts and values of the mechanism file (file_values.py)
    pole_factors: tuple[float, ...] = (2.0, 0.5)  # teeth of the rotor for poles, and steps a turn for poles
    ratio_factors: tuple[float, ...] = (1.03, 1.1, 1.3, 2.0)  # and 1/x: tried before the best is searched
    ratio_promising: float = 1.2  # cost of the file's ratio over the best of these; then the best is searched
    count_gain: float = 2.0  # cost of the file's counts over that of others; no false alarm in 11 clean campaigns
    same_count: float = 0.01  # relative distance of equal counts: a better start is luck; a tooth of 50 is 0.02
    inertia_factor: float = 2.0  # error of a known inertia that is searched; not measured
    value_factor: float = 1e3  # reach of the search for a wrong value: units are wrong by a hundred or a thousand
    value_rivals: float = 10.0  # cost over the best up to which a value is named too; others cost 50 times as much

    # Records against the others, and all records together (alternatives.py, agreement.py, all_records.py)
    first_steps: float = 2.0  # full steps within a record's first moments; not measured
    likelihood_margin: float = 2.0 * math.log(100.0)  # sigma^2; of readings this near, the least change; not measured
    least_gain: float = 0.5  # smallest factor of a gain that is tried, the largest is its inverse; not measured
    same_gain: float = 0.02  # distance from 1 up to which a gain is as declared; not measured
    judged_samples: int = 1_000_000  # most samples over which a record is judged: 100 s at 10 kHz, 16 MB
    start_batches: int = 4  # batches of refined starts before records are believed to disagree; not measured
    grown_readings: int = 3  # readings that are grown together with the other records; not measured
    bend_gain: float = 2.0  # residual of a straight sensor over that of a bent one; not measured
    least_bend: float = 0.05  # shortfall at the largest torque; not measured
    further_ratio: float = 2.0  # factor by which a common reading has to follow more samples; not measured
    late_s: float = 0.02  # largest common trigger error that is searched; not measured
    least_late_s: float = 1e-3  # smallest that is reported: an undeclared filter delays by less; not measured


RULES = ReadingRules()
