"""Warnings about records that are usable but suspicious under their command, one line each."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from mechid.campaign.campaign import CampaignRecord
from mechid.campaign.place import Place
from mechid.command import MeasuredCommand
from mechid.errors import UsageError
from mechid.records import Record, Role
from mechid.signal.moments import standard_deviation
from mechid.units import SI_UNIT

FAR_OFF = 1e6
"""Ratio between a noise level and the standard deviation of its channel, either way, beyond which it is an error."""
RADIANS = 3e-4
"""Relative tolerance for a start angle at a multiple of pi/4."""
TOO_DENSE = "check the rate, and whether the time is in ms or the sample rate in kHz"
# A choice, not measured.
MEAN_SHARE = 0.5
"""Ratio of mean to RMS above which an input drives the mean of outputs."""
WITH_MEAN = (
    *("current", *(f"current_phase_{x}" for x in "abcd")),
    *("rotor_rate", "output_rate", "velocity"),
)
"""Outputs whose mean follows from the mean of the input; that of an angle depends on the zero of its encoder."""
# A record as long as its command ends one sample interval before the command.
SLACK_SAMPLES = 1.5
"""Tolerance of the start and the end of a record, in samples."""


def record_warnings(record: CampaignRecord, place: Place) -> Iterator[str]:
    """Yield the warnings of one record; those about samples only if its file was read.

    Parameters
    ----------
    record : CampaignRecord
    place : Place
        Place of its table in the campaign file.

    Raises
    ------
    InputFileError
        The command makes more steps than fit in memory, or a `noise_sigma` is too large to estimate anything.
    """
    lines = [*_unused_channels(record)]
    lines += _radians(record.command.start_angle_deg)
    if record.data is not None:
        lines += [*record.data.warnings, *_noise_levels(record, record.data, place)]
    lines += _means_removed(record)
    if record.data is not None and not isinstance(record.command, MeasuredCommand):
        lines += [*_start(record, record.data), *_end(record, record.data)]
        lines += _edges(record, record.data, place)
    yield from (f'record "{record.name}": {line}' for line in lines)


def same_file_warnings(records: Sequence[CampaignRecord]) -> Iterator[str]:
    """Yield a warning for each record with the same samples, from the same part of the same file, as an earlier one."""
    seen: dict[tuple[object, ...], str] = {}
    for record in records:
        if record.data is None:
            continue
        # Digest, columns and time range together identify the same part of the same file.
        columns = tuple(channel.column for channel in record.data.channels)
        part = (record.data.digest, columns, record.data.time_start_s, record.data.samples)
        earlier = seen.setdefault(part, record.name)
        if earlier != record.name:
            same = f'{record.spec.path} is the same file as that of "{earlier}"'
            yield f'record "{record.name}": {same}; is that meant?'


def _radians(start_angle_deg: float) -> Iterator[str]:
    """Warn of a start angle at a multiple of pi/4, which was probably given in radians."""
    eighths = start_angle_deg / (0.25 * math.pi)
    # Multiples up to a full turn; 0 is a common angle in degrees too.
    if 0.5 < abs(eighths) < 8.5 and abs(eighths / round(eighths) - 1.0) < RADIANS:
        yield (
            f"start_angle_deg = {start_angle_deg:.9g}: is this in rad? it is read in degrees; "
            f"write {math.degrees(start_angle_deg):.4g} if so"
        )


def _unused_channels(record: CampaignRecord) -> Iterator[str]:
    outputs = [channel.quantity for channel in record.spec.channels if channel.role is Role.OUTPUT]
    others = [quantity for quantity in outputs if quantity not in {match.quantity for match in record.matches}]
    if others:
        yield f"{', '.join(others)}: not used, the mechanism does not give it"


def _means_removed(record: CampaignRecord) -> Iterator[str]:
    """Warn if the mean of an output is projected out by default although the input has a mean that drives it."""
    if not isinstance(record.command, MeasuredCommand):
        return
    for channel in record.command.channels:
        mean, rms = float(np.mean(channel.samples)), float(np.sqrt(np.mean(np.square(channel.samples))))
        if not abs(mean) > MEAN_SHARE * rms > 0.0:
            continue
        for match in (m for m in record.matches if m.offset_assumed and m.offset and m.quantity in WITH_MEAN):
            output, of = match.quantity, f"{mean:.4g} {SI_UNIT[channel.quantity]}"
            yield (
                f"{output}: its mean is projected out as an offset, by default, although the {channel.quantity} that "
                f"drives it has a mean, {of}: the mean of the {output} then tells nothing about "
                "resistance or friction; write offset = false in its channel, or offset = true if its zero is not known"
            )


def _noise_levels(record: CampaignRecord, data: Record, place: Place) -> Iterator[str]:
    """Refuse or warn of noise levels far from the spread of their channels, mostly numbers in another unit."""
    for match in record.matches:
        if match.noise_sigma is None:
            continue
        channel = data.channel(match.quantity)
        spread = standard_deviation(channel.data) / abs(channel.scale)
        comparison = f"found {match.noise_sigma:.4g}, where the channel's own standard deviation is {spread:.4g}"
        if match.noise_sigma > FAR_OFF * spread:
            index = [c.quantity for c in record.spec.channels].index(match.quantity)
            at = place.key("channels").item(index).key("noise_sigma")
            raise at.error(f"{comparison} in the units of the file; at that level any motion fits")
        if match.noise_sigma * FAR_OFF < spread:
            yield f"noise_sigma of {match.quantity}: {comparison}; a millionth of that is used"


def _start(record: CampaignRecord, data: Record) -> Iterator[str]:
    """Warn if the command starts before the first sample, often because the recorder has its own clock."""
    # A record with an estimated start may begin in motion.
    if record.start:
        return
    offset = record.time_offset.value
    windowed = record.spec.conditioning.window_s is not None
    if not windowed and data.time_start_s - offset > SLACK_SAMPLES * data.sample_interval_s:
        yield (
            f"the command starts {data.time_start_s - offset:.6g} s before the first sample; "
            f"if they start together, write time_offset_s = {data.time_start_s:.9g}"
        )


def _end(record: CampaignRecord, data: Record) -> Iterator[str]:
    """Warn if a rate profile continues after the last sample."""
    end = data.time_start_s + data.duration_s - record.time_offset.value
    last = record.command.rate.times_s[-1]
    window = record.spec.conditioning.window_s
    if end <= 0.0:
        yield "the record ends before its command starts; check time_offset_s"
    elif (window is None or last < window[1]) and last - end > SLACK_SAMPLES * data.sample_interval_s:
        yield f"the record ends at {end:.6g} s of a command that goes on to {last:.6g} s; is it whole?"


def _edges(record: CampaignRecord, data: Record, place: Place) -> Iterator[str]:
    """Warn of steps denser than the samples, or of none: mostly a wrong or missing rate."""
    duration = max(data.time_start_s + data.duration_s - record.time_offset.value, 0.0)
    try:
        most = record.command.max_edges_per_sample(data.sample_interval_s, duration)
    except UsageError as error:
        raise place.key("command").error(str(error)) from error
    if most == 0 and duration > 0.0:
        yield "its command makes no step until its last sample; is the rate right?"
    if most > 1:
        yield f"up to {most} steps fall between two samples; they are simulated exactly, {TOO_DENSE}"
