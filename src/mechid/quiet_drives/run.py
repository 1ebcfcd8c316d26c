"""Public function that makes a mechanism quiet: microstep table, rates and stepping."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.budgets.attractors import steady_states
from mechid.budgets.flying_mechanism import Estimate, flying_estimate
from mechid.budgets.operating_mode import OperatingMode, usual_highest_hz
from mechid.budgets.prediction import Prediction, TorqueOverRate, predict
from mechid.budgets.shares import deviations
from mechid.campaign import Campaign
from mechid.campaign.campaign_file import FILE_NAME as CAMPAIGN_NAME
from mechid.command import MeasuredCommand
from mechid.command.phase_table import nominal_table
from mechid.designs.step_loss import is_stepper
from mechid.errors import FitError, InputFileError
from mechid.fits.load import load_fit, result_folder
from mechid.identification.computation.parallel import one_core_algebra
from mechid.identification.result.fit import Fit
from mechid.identification.result.fit_file import read_fit
from mechid.identification.result.grade import GRADE_WORDS, Grade
from mechid.identification.result.journal_file import FILE_NAME as JOURNAL_NAME
from mechid.plant.mechanism import Mechanism
from mechid.progress.listening import line_receiver
from mechid.quiet_drives.confirmation import confirm, noise_density
from mechid.quiet_drives.design_file import QuietDesign, quiet_design_of, read_quiet_file
from mechid.quiet_drives.driver_layouts import driver_layouts
from mechid.quiet_drives.improvement import improvement, moved_mechanisms
from mechid.quiet_drives.quiet_drive import QuietDrive
from mechid.quiet_drives.rate_survey import survey
from mechid.quiet_drives.reserved_search import search_within_reserve
from mechid.quiet_drives.rounding import round_table
from mechid.quiet_drives.settings import QUIET
from mechid.quiet_drives.step_reserve import reserve_rule, reserves
from mechid.quiet_drives.table_basis import table_entries, table_harmonics
from mechid.quiet_drives.table_command import table_command
from mechid.quiet_drives.table_cost import TableCost
from mechid.quiet_drives.table_search import design_places, range_places, rise_db
from mechid.records.components import TORQUE
from mechid.simulation.repetition import MIRRORED, repetition
from mechid.specification.requirement import Requirement

DEFAULT_ENDS, DEFAULT_MICROSTEPS = (10.0, 120.0), 16
TABLE = "table"
NEXT = "mechid diagnose {fit} --out DIR shows what the model lacks"


def quiet(
    fit: Fit | Path | str,
    design: QuietDesign | Mapping[str, Any] | Path | str | None = None,
    *,
    fleet: Sequence[Fit | Path | str] = (),
    say: Callable[[str], None] | None = None,
) -> QuietDrive:
    """Find the microstep table, rates and stepping with which an identified mechanism disturbs least.

    Parameters
    ----------
    fit : Fit or Path
        A fit in memory, or its result folder.
    design : QuietDesign, mapping, Path or None
        quiet.toml, or the tables that it would hold (docs/quiet.md); None takes the defaults.
    fleet : sequence of Fit or Path
        Fits of other units, on which the table is tried.
    say : callable or None
        Called with single lines; None shows the last one in a notebook and nothing elsewhere.

    Returns
    -------
    QuietDrive
        Torques in N m, rates in full steps/s, tables in fractions of the nominal peak.

    Raises
    ------
    InputFileError
        The fit or the design is missing or wrong, or the mechanism is not driven by steps.
    FitError
        The fit has grade C or failed, or the rotor loses steps at a rate of the range.

    Examples
    --------
    >>> import mechid
    >>> found = mechid.quiet("fit", {"rates": [30.0], "bits": 8})  # doctest: +SKIP
    >>> [gain.gain_db for gain in found.improvement.gains]  # doctest: +SKIP
    [27.1]
    """
    wanted = _design_of(design)
    found = _read(fit)
    with line_receiver(say) as tell, one_core_algebra():
        return _quiet(found, wanted, {_unit_name(one, k): _unit(one, wanted) for k, one in enumerate(fleet)}, tell)


def _design_of(design: QuietDesign | Mapping[str, Any] | Path | str | None) -> QuietDesign:
    if design is None or isinstance(design, QuietDesign):
        return design or QuietDesign()
    return quiet_design_of(design) if isinstance(design, Mapping) else read_quiet_file(design)


def _read(fit: Fit | Path | str) -> Fit:
    """Return a fit; one whose folder holds residuals but no campaign is read alone: a table needs no records."""
    if isinstance(fit, Fit):
        return fit
    folder = result_folder(Path(fit))
    has_campaign = any((folder / name).is_file() for name in (CAMPAIGN_NAME, JOURNAL_NAME))
    return read_fit(folder) if Path(fit).is_dir() and not has_campaign else load_fit(fit)


def _unit_name(fit: Fit | Path | str, index: int) -> str:
    return f"unit {index + 1}" if isinstance(fit, Fit) else Path(fit).name


def _unit(fit: Fit | Path | str, design: QuietDesign) -> Mechanism:
    return _estimate(_read(fit), design).mechanism


def _estimate(fit: Fit, design: QuietDesign) -> Estimate:
    """Return the flying estimate of a fit that can be used."""
    if not fit.grade.good:
        remedy = NEXT.format(fit=fit.folder or "FIT") if fit.grade is Grade.C else "identify anew"
        raise FitError(f"{fit.source}: {GRADE_WORDS[fit.grade]} {remedy}")
    estimate = flying_estimate(fit, design.flight)
    if not is_stepper(estimate.mechanism):
        raise InputFileError(
            f"{fit.source}: the mechanism is not driven step by step, so that it has no microstep table"
        )
    if estimate.mechanism.phases == 3:
        raise InputFileError(f"{fit.source}: the motor has 3 phases; a microstep table is of two")
    if estimate.mechanism.pulse:
        raise InputFileError(
            f"{fit.source}: stepper.pulses: a quiet microstep table is of a driver that holds its phases"
        )
    return estimate


def _quiet(fit: Fit, wanted: QuietDesign, units: Mapping[str, Mechanism], say: Callable[[str], None]) -> QuietDrive:
    estimate = _estimate(fit, wanted)
    design = _fill_in(wanted, fit.campaign)
    mechanism, rng = estimate.mechanism, np.random.default_rng(design.seed)
    draws = moved_mechanisms(estimate, deviations(estimate.covariance, QUIET.survey_draws, rng))
    base, ends = nominal_table(design.microsteps or DEFAULT_MICROSTEPS), design.ends or DEFAULT_ENDS

    begun = time.process_time()
    mirrored = repetition(mechanism).steps == MIRRORED
    say(f"nominal table at {len(design.rates)} design rates and over the range")
    places = design_places([mechanism, *draws[: QUIET.draws]], base, design.rates, ends, design.quantity)
    cost = TableCost(places, design.orders, base, design.peak)
    checked = range_places(mechanism, base, np.geomspace(*ends, QUIET.checked_rates).tolist(), design.quantity)
    changes = table_harmonics(len(base) // 4, QUIET.highest_harmonic, mirrored=mirrored)
    searched, exact, kept = search_within_reserve(
        mechanism, cost, changes, checked, design.rates, design.pull_out_share, say
    )
    say(f"rounding to {design.bits} bits")
    entries = table_entries(len(base) // 4, mirrored=mirrored)
    rule = reserve_rule(mechanism, base, design.rates, design.pull_out_share)
    rounded = round_table(exact, searched.cost, entries, design.bits, design.peak, rule)
    took = time.process_time() - begun

    table = rounded.values
    rises = [(rise_db(place, table), place.torque.rate) for place in checked]
    say("emission before and after")
    bettered = improvement(estimate, base, table, design.rates, units, design.seed, design.quantity)
    say("levels over the rate of all steppings")
    tables = _tables(design, fit.campaign, base, table)
    means = design.mean_rates or design.rates
    rates = np.geomspace(*ends, QUIET.survey_rates)
    levels = survey([mechanism, *draws], tables, rates, means, design.rms_limit, design.quantity)
    return QuietDrive(
        design=design,
        nominal=base,
        exact=exact,
        rounded=rounded,
        improvement=bettered,
        reserves=reserves(mechanism, base, table, design.rates),
        kept_share=kept,
        worst_rise_db=max(rises)[0],
        worst_rate=max(rises)[1],
        survey=levels,
        predictions=_predictions(estimate, design, base, table),
        drivers=driver_layouts(mechanism, searched.cost, table, design.rates, say) if mirrored else (),
        confirmations=confirm(bettered.after, noise_density(fit)),
        source=fit.source,
        grade=str(fit.grade),
        synthetic=estimate.synthetic,
        digest=estimate.digest,
        cpu_s=took,
    )


def _fill_in(design: QuietDesign, campaign: Campaign | None) -> QuietDesign:
    """Return a design with microsteps, range and rates of the campaign where it names none."""
    commands = [r.command for r in campaign.records if not isinstance(r.command, MeasuredCommand)] if campaign else []
    micro = [c.microsteps for c in commands if c.stepping == "micro"]
    rates = [abs(rate) for c in commands for rate in c.rate.rates if rate != 0.0]
    ends = design.ends or ((min(rates), max(rates)) if rates and min(rates) < max(rates) else DEFAULT_ENDS)
    return replace(
        design,
        microsteps=design.microsteps or (micro[0] if micro else DEFAULT_MICROSTEPS),
        ends=ends,
        rates=design.rates or (float(np.sqrt(ends[0] * ends[1])),),
    )


def _tables(
    design: QuietDesign, campaign: Campaign | None, base: FloatArray, table: FloatArray
) -> dict[str, FloatArray]:
    """Return the table of each stepping, by its name."""
    out = {}
    for stepping in design.steppings:
        if stepping == "micro":
            out[f"micro{len(base) // 4}"] = base
            out[TABLE] = table
        else:
            out[stepping] = nominal_table(1 if stepping == "full" else 2)
    return out


def _predictions(
    estimate: Estimate, design: QuietDesign, base: FloatArray, table: FloatArray
) -> dict[str, tuple[Prediction, ...]]:
    """Return the verdicts on the requirements at the design rates, with the nominal table and with the found one."""
    if not design.requirements:
        return {}
    return {
        name: _judge(estimate, design.requirements, own, design.rates, design.seed)
        for name, own in (("nominal", base), (TABLE, table))
    }


def _judge(
    estimate: Estimate, requirements: Sequence[Requirement], table: FloatArray, rates: Sequence[float], seed: int
) -> tuple[Prediction, ...]:
    command = table_command(table, 1.0)
    own = np.sort(np.array(rates, dtype=np.float64))
    mode = OperatingMode(
        name=f"micro{len(table) // 4}",
        command=command,
        rates=own,
        highest_hz=usual_highest_hz(command, float(own[-1])),
    )
    torque = TorqueOverRate(mode=mode, states=steady_states(estimate.mechanism, mode, estimate.names, 1))
    return predict(requirements, (TORQUE,), (torque,), estimate, seed)
