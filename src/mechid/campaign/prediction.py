"""Simulation of records with the parameter values of the mechanism file."""

from __future__ import annotations

import math
from dataclasses import replace

from mechid.campaign.campaign import Campaign, CampaignRecord, key_in_record
from mechid.campaign.measured_input import with_inputs
from mechid.campaign.planned_record import planned_duration_s, planned_rate_hz
from mechid.command import MeasuredCommand
from mechid.errors import InputFileError, UsageError
from mechid.records import Record, read_record
from mechid.simulation.accuracy import simulate_accurately
from mechid.simulation.simulator import Simulator, TimeBase, simulate_run
from mechid.simulation.start import Start
from mechid.simulation.trajectory import Trajectory

# More samples would fill the memory and suggest an error in the rate or duration.
MOST_SAMPLES = 200_000_000
"""Largest number of samples of a simulation."""


def simulate(
    campaign: Campaign,
    record: str | None = None,
    *,
    sample_rate_hz: float | None = None,
    duration_s: float | None = None,
    substeps: int | None = None,
) -> Trajectory:
    """Simulate the command of one record at the mechanism's values, without noise, offset or drift.

    Parameters
    ----------
    campaign : Campaign
    record : str or None
        Name of the record; None if there is only one.
    sample_rate_hz, duration_s : float or None
        None takes the values of the record's file, which is read if necessary, or those of a planned record
        (`campaign.planned_record`).
    substeps : int or None
        Integration steps per sample; None chooses them for the specified accuracy.

    Returns
    -------
    Trajectory
        On the time base of the record; `outcome` tells whether the simulation diverged.

    Raises
    ------
    UsageError
        There is no such record, or the rate or duration is invalid.
    RecordError
        The file of the record is missing or unusable.
    InputFileError
        The command makes more steps than fit in memory.

    Examples
    --------
    >>> from mechid.campaign import load_campaign
    >>> trajectory = simulate(load_campaign("bench"), "full_46")  # doctest: +SKIP
    """
    chosen = campaign.record(record) if record is not None else _only_record(campaign)
    return _simulate_record(chosen, campaign, (sample_rate_hz, duration_s), substeps).in_memory


def _simulate_record(
    chosen: CampaignRecord,
    campaign: Campaign,
    base_options: tuple[float | None, float | None],
    substeps: int | None = None,
) -> Trajectory:
    """Simulate a record as `simulate` does, a long one in files; `base_options` are sample rate and duration."""
    if isinstance(chosen.command, MeasuredCommand):
        chosen = _with_measured_inputs(chosen, campaign)
    base = time_base(chosen, campaign, *base_options)
    timing, end_s = chosen.timing, base.start_s + base.samples * base.interval_s
    # Bounds the shift between record and command time over the whole record, from the offset and the clock error.
    latest_s = abs(timing.offset_s) + abs(timing.command_s(end_s) + timing.offset_s - end_s)
    start = Start({key_in_record(q.name): q.value for q in chosen.start})
    simulator = Simulator(campaign.mechanism.plant, chosen.command, base, latest_s=latest_s, start=start)
    # Built here, since the excitation raises for too many steps and the message has to name the record.
    try:
        _ = simulator.excitation
    except UsageError as error:
        raise InputFileError(f'{campaign.path.name}: record "{chosen.name}": command: {error}') from error
    p = campaign.mechanism.kernel_values({q.replaces: q.value for q in chosen.overrides})
    if substeps is None:
        return simulate_accurately(simulator, p, timing=timing)
    if substeps < 1:
        raise UsageError(f"substeps: found {substeps}; write 1 or more, or leave it out")
    return simulate_run(simulator.run(p, timing=timing, substeps=substeps))


def simulate_all(
    campaign: Campaign, *, sample_rate_hz: float | None = None, duration_s: float | None = None
) -> dict[str, Trajectory]:
    """Simulate every record as `simulate` does; long trajectories stay in files and are read in blocks.

    Parameters
    ----------
    campaign : Campaign
    sample_rate_hz, duration_s : float or None
        For records without samples; measured records keep their own time base.

    Raises
    ------
    UsageError
        The rate or duration is invalid.
    RecordError
        A record's file is missing or unusable.
    InputFileError
        A command makes more steps than fit in memory.

    Examples
    --------
    >>> from mechid import load_campaign, simulate_all
    >>> runs = simulate_all(load_campaign("bench"))  # doctest: +SKIP
    """
    _refuse_base(sample_rate_hz, duration_s)
    return {
        r.name: _simulate_record(r, campaign, (None, None) if _is_measured(r) else (sample_rate_hz, duration_s))
        for r in campaign.records
    }


def time_base_warnings(campaign: Campaign, sample_rate_hz: float | None, duration_s: float | None) -> tuple[str, ...]:
    """Return the assumed time bases of records without a file, or a warning if the requested time base is unused.

    Raises UsageError if the requested time base is invalid.
    """
    _refuse_base(sample_rate_hz, duration_s)
    planned = [r for r in campaign.records if not _is_measured(r)]
    if not planned and not (sample_rate_hz is None and duration_s is None):
        return ("every record has a file, whose time base is kept: sample rate and duration are not used",)
    if sample_rate_hz is not None and duration_s is not None:
        return ()
    bases = ((r.name, time_base(r, campaign, sample_rate_hz, duration_s)) for r in planned)
    return tuple(
        f'record "{name}" has no file: simulated for {base.duration_s:.9g} s at {base.sample_rate_hz:.9g} Hz; '
        "--duration-s and --sample-rate-hz choose otherwise"
        for name, base in bases
    )


def _is_measured(record: CampaignRecord) -> bool:
    return record.file is not None or record.data is not None


def _only_record(campaign: Campaign) -> CampaignRecord:
    if len(campaign.records) != 1:
        names = ", ".join(record.name for record in campaign.records)
        raise UsageError(f"{campaign.path.name}: name one of its records: {names}")
    return campaign.records[0]


def time_base(
    record: CampaignRecord, campaign: Campaign, rate_hz: float | None = None, duration_s: float | None = None
) -> TimeBase:
    """Return the time base of a record from the given values, its file or the defaults of a planned record."""
    data = record.data if rate_hz is not None and duration_s is not None else _data(record)
    start_s = data.time_start_s if data else 0.0
    if data and rate_hz is None and duration_s is None:
        return TimeBase(data.sample_rate_hz, data.samples, start_s)
    if rate_hz is None:
        known = (r.data.sample_rate_hz for r in campaign.records if r.data is not None)
        rate_hz = data.sample_rate_hz if data else planned_rate_hz(record, known)
    if duration_s is None:
        duration_s = data.duration_s if data else planned_duration_s(record.command)
    return TimeBase(rate_hz, _samples(rate_hz, duration_s), start_s)


def _with_measured_inputs(record: CampaignRecord, campaign: Campaign) -> CampaignRecord:
    """Add the measured inputs to the command of a record."""
    data = _data(record)
    if data is None:
        raise UsageError(f'record "{record.name}" is driven by measured channels; name its file')
    return with_inputs(replace(record, data=data), data, campaign.mechanism)


def _data(record: CampaignRecord) -> Record | None:
    if record.data is None and record.file is not None:
        return read_record(record.file, record.spec)
    return record.data


def _samples(rate_hz: float, duration_s: float) -> int:
    """Return the number of samples from 0 to the duration, both included."""
    _refuse_base(rate_hz, duration_s)
    count = rate_hz * duration_s + 1.0
    if count > MOST_SAMPLES:
        raise UsageError(f"{count:.3g} samples, more than {MOST_SAMPLES}; check sample rate and duration")
    # Rounding may leave an integer product just below the integer.
    return math.floor(count * (1.0 + 1e-12))


def _refuse_base(rate_hz: float | None, duration_s: float | None) -> None:
    """Refuse an invalid sample rate or duration; None is accepted."""
    if rate_hz is not None and not (math.isfinite(rate_hz) and rate_hz > 0.0):
        raise UsageError(f"sample rate: found {rate_hz:.9g}; write the samples per second, above 0")
    if duration_s is not None and not (math.isfinite(duration_s) and duration_s >= 0.0):
        raise UsageError(f"duration: found {duration_s:.9g}; write a time in s, 0 or more")
