"""Assessor: takes the records one by one, keeps their lines, spectra and verdicts, and forgets their samples."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from mechid.analysis.commanded_rate import commanded_rate
from mechid.analysis.look import Drive
from mechid.arrays import FloatArray
from mechid.campaign.campaign import CampaignRecord
from mechid.command.words import command_words
from mechid.emissions.background import HOLDING, Background, choose_background
from mechid.emissions.declared import Declared
from mechid.emissions.emission import Assessment, AtRate, Emission, EmissionSpectrum, SourceFile
from mechid.emissions.emission_line import EmissionLine
from mechid.emissions.lines import find_lines, mains_of, orders_of
from mechid.emissions.measured import Stretch, background_amplitude, measure
from mechid.emissions.settings import EMISSION
from mechid.emissions.spectra import Spectra, channel_spectra, window_length
from mechid.emissions.trust import BenchUse, bench_use
from mechid.errors import RecordError
from mechid.exports.handover import Trial
from mechid.plant.mechanism import NamedLine
from mechid.records import Record
from mechid.signal.envelope import peak_groups
from mechid.simulation.simulator import TimeBase
from mechid.specification.requirement import AMPLITUDE, PSD, Requirement, direction_of, judged_parts, unit_of
from mechid.specification.verdict import combine, judge

# `window_length` returns no window below 16 samples.
LEAST_SAMPLES = 16 * EMISSION.least_windows
NO_BAND = (float("nan"), float("nan"))
LINE_ALPHA = 0.025
"""Chance that the background's line at a listed line is larger than stated."""


class Assessor:
    """Judges records one after the other.

    Parameters
    ----------
    declared : Declared
    """

    def __init__(self, declared: Declared) -> None:
        self._declared = declared
        self._at_rates: dict[str, list[AtRate]] = {one.name: [] for one in declared.requirements}
        self._lines: list[EmissionLine] = []
        self._spectra: list[EmissionSpectrum] = []
        self._backgrounds: dict[str, EmissionSpectrum] = {}
        self._bands: dict[str, list[tuple[float, float]]] = {}
        self._sources: list[SourceFile] = []
        self._mains: dict[str, set[float]] = {}
        self.trials: list[Trial] = []
        self._chosen = {
            direction: choose_background(declared.backgrounds, direction)
            for direction in sorted({declared.own_direction(one) for one in declared.requirements})
        }

    def add(self, record: CampaignRecord) -> None:
        """Judge a record that was read.

        Raises
        ------
        RecordError
            It is too short, or a background does not go with it.
        """
        data = record.data
        assert data is not None
        if data.samples < LEAST_SAMPLES:
            raise RecordError(f'record "{record.name}": has {data.samples} samples; {LEAST_SAMPLES} are needed')
        for background in self._declared.backgrounds:
            background.refuse_other_clock(data)
        parts = list(_stretches(record, data))
        if np.isfinite(parts[0][1]):
            base = TimeBase(data.sample_rate_hz, data.samples, data.time_start_s)
            self.trials.append(Trial(record.name, record.command, base))
        named = {direction_of(one.quantity, self._declared.mounting): one.data[:] for one in data.channels}
        samples = {direction: y for direction, y in named.items() if direction is not None}
        for part, rate in parts:
            stretches = {d: self._stretch(record.name, data, y[part], (d, rate)) for d, y in samples.items()}
            densities = {d: one.spectra.density for d, one in stretches.items()}
            for direction, stretch in stretches.items():
                # A load's error is made of all loads, through cross-talk and the moves of moments.
                error = self._declared.interface.error_density(direction, stretch.spectra.frequency_hz, densities)
                self._judge(record.name, data, replace(stretch, bench_error=error), (direction, len(parts)))
        source = _source(data, "run", tuple(rate for _, rate in parts))
        command = command_words(record.command)
        self._sources.append(replace(source, command=command, channels=record.spec.channels))

    def _judge(self, name: str, data: Record, stretch: Stretch, at: tuple[str, int]) -> None:
        direction, parts = at
        rate, length = stretch.rate, window_length(stretch.y.size, data.sample_rate_hz)
        self._bands.setdefault(direction, []).append(stretch.spectra.usable_hz)
        self._keep(name, direction, stretch)
        for requirement in self._declared.requirements:
            if self._declared.own_direction(requirement) == direction and requirement.holds_at(rate):
                fine = self._fine(stretch, requirement, data, length)
                measured = measure(stretch, requirement, len(self._declared.records) * parts, fine)
                judged = judge(measured, requirement, name, rate)
                self._at_rates[requirement.name].append(AtRate(record=name, rate=rate, judged=judged))

    def _stretch(self, name: str, data: Record, y: FloatArray, at: tuple[str, float]) -> Stretch:
        direction, rate = at
        length = window_length(y.size, data.sample_rate_hz)
        spectra = channel_spectra(y, data.sample_rate_hz, length, self._declared.interface.band_hz(direction))
        lines = find_lines(spectra)
        background = self._chosen.get(direction)
        if background is None:
            return Stretch(y=y, rate=rate, spectra=spectra, lines=lines)
        background.refuse_motion(rate, name, direction, length)
        return Stretch(
            y=y,
            rate=rate,
            spectra=spectra,
            lines=lines,
            background=background.spectra(direction, length),
            background_lines=background.lines(direction, length),
            background_y=background.samples(direction),
        )

    def _fine(
        self, stretch: Stretch, requirement: Requirement, data: Record, length: int
    ) -> tuple[Spectra, Spectra | None] | None:
        """Return the spectra at the resolution of a power density, no finer than the record's own windows."""
        if requirement.kind != PSD:
            return None
        # Even, since windows overlap by half.
        own = min(2 * max(round(0.5 * data.sample_rate_hz / requirement.resolution_hz), 8), length)
        direction = self._declared.own_direction(requirement)
        background = self._chosen.get(direction)
        return (
            channel_spectra(stretch.y, data.sample_rate_hz, own, stretch.spectra.bench_hz),
            background.spectra(direction, own) if background else None,
        )

    def _keep(self, name: str, direction: str, stretch: Stretch) -> None:
        spectra, lines = stretch.spectra, stretch.lines
        unit = unit_of(direction, AMPLITUDE)
        mains = mains_of(lines.frequency_hz, spectra)
        self._mains.setdefault(direction, set()).update(mains[~np.isnan(mains)].tolist())
        sigma = lines.sigma
        if stretch.bench_error is not None:
            sigma = np.hypot(sigma, np.sqrt(stretch.bench_error[lines.bins] * spectra.peak_scale))
        within = EMISSION.near_bins * spectra.bin_hz
        columns = (
            lines.frequency_hz,
            orders_of(lines.frequency_hz, stretch.rate, spectra.bin_hz),
            lines.amplitude,
            sigma,
            background_amplitude(stretch, LINE_ALPHA),
            mains,
        )
        self._lines += [
            EmissionLine(
                record=name,
                rate=stretch.rate,
                direction=direction,
                frequency_hz=f,
                order=order,
                amplitude=amplitude,
                sigma=sigma,
                background=beside,
                mains_hz=multiple,
                named=", ".join(_names_at(f, stretch, self._declared.named, within)),
                unit=unit,
            )
            for f, order, amplitude, sigma, beside, multiple in zip(*(c.tolist() for c in columns), strict=True)
        ]
        self._spectra.append(_group_bins(name, stretch.rate, direction, spectra))
        if stretch.background is not None and direction not in self._backgrounds:
            chosen = self._chosen[direction]
            assert chosen is not None
            self._backgrounds[direction] = _group_bins(chosen.name, np.nan, direction, stretch.background)

    def result(self) -> Emission:
        """Return the verdicts over all records that were added."""
        bands = {direction: _common_band(own) for direction, own in self._bands.items()}
        assessments = tuple(
            Assessment(
                requirement=one,
                judged=combine([at.judged for at in self._at_rates[one.name]]),
                at_rates=tuple(self._at_rates[one.name]),
                judged_hz=judged_parts(one, bands.get(self._declared.own_direction(one), NO_BAND))[0],
            )
            for one in self._declared.requirements
        )
        rates = [one.sample_rate_hz for one in self._sources]
        bench = bench_use(self._declared.interface, self._chosen, min(rates, default=np.nan))
        backgrounds = tuple(_source(one.record, one.state, ()) for one in self._declared.backgrounds)
        return Emission(
            assessments=assessments,
            lines=tuple(self._lines),
            spectra=tuple(self._spectra),
            backgrounds=tuple(self._backgrounds.values()),
            usable_hz=_common_band(list(bands.values())),
            bands_hz=bands,
            bench=bench,
            notes=(*bench.notes(), *self._notes(assessments, bands), *_beyond_trust(assessments, bench)),
            sources=(*self._sources, *backgrounds),
            synthetic=self._declared.synthetic,
            test=self._declared.test,
            inputs=self._declared.inputs,
        )

    def _notes(self, assessments: tuple[Assessment, ...], bands: dict[str, tuple[float, float]]) -> Iterator[str]:
        for one in assessments:
            band = bands.get(self._declared.own_direction(one.requirement), NO_BAND)
            first, last = one.requirement.mask.range_hz
            if not one.at_rates:
                yield f"{one.requirement.name}: no record has a step rate in its rates; it is not judged."
            elif one.judged_hz is None:
                yield (
                    f"{one.requirement.name}: its mask, {first:.4g} to {last:.4g} Hz, is outside the band of "
                    f"records and bench, {band[0]:.4g} to {band[1]:.4g} Hz; it is not judged."
                )
            elif left := judged_parts(one.requirement, band)[1]:
                parts = ", ".join(f"{a:.4g} to {b:.4g}" for a, b in left)
                yield (
                    f"{one.requirement.name}: not judged is its mask at {parts} Hz, outside the band of records and "
                    f"bench, {band[0]:.4g} to {band[1]:.4g} Hz."
                )
        for chosen in dict.fromkeys(self._chosen.values()):
            yield _background_note(", ".join(d for d, one in self._chosen.items() if one is chosen), chosen)
        yield from self._mains_notes()

    def _mains_notes(self) -> Iterator[str]:
        """Yield what became of lines of the mains, once for all directions in which it was the same."""
        same: dict[tuple[str, str], list[str]] = {}
        for direction, found in self._mains.items():
            own = [one for one in self._declared.requirements if self._declared.own_direction(one) == direction]
            excluded = [one.name for one in own if one.exclude_mains]
            what = f"left out of {', '.join(excluded)} as declared, but where they are orders of the step rate"
            counted = "counted as emission; exclude_mains = true in a requirement leaves them out"
            if found:
                where = ", ".join(f"{f:.4g}" for f in sorted(found))
                same.setdefault((where, what if excluded else counted), []).append(direction)
        for (where, what), directions in same.items():
            yield f"{', '.join(directions)}: lines of the mains at {where} Hz; {what}."


def _names_at(frequency_hz: float, stretch: Stretch, named: Sequence[NamedLine], within_hz: float) -> Iterator[str]:
    """Yield the names of the mechanism's lines at a frequency."""
    for one in named:
        if any(abs(f - frequency_hz) <= within_hz for f in one.lines_hz(stretch.rate, stretch.spectra.sample_rate_hz)):
            yield one.name


def _common_band(bands: list[tuple[float, float]]) -> tuple[float, float]:
    """Return the band that all of them have."""
    return max((band[0] for band in bands), default=np.nan), min((band[1] for band in bands), default=np.nan)


def _beyond_trust(assessments: tuple[Assessment, ...], bench: BenchUse) -> Iterator[str]:
    """Yield the requirements that are decided at a frequency up to which the table is not trusted."""
    beyond = [
        f"{one.requirement.name} ({one.judged.worst.frequency_hz:.4g} Hz)"
        for one in assessments
        if one.judged.worst is not None and one.judged.worst.frequency_hz > bench.trusted_hz
    ]
    # A correction has a band for each direction, and nothing is judged beyond it.
    if beyond and not bench.response:
        yield f"Decided above {bench.trusted_hz:.3g} Hz, where the table is not trusted: {', '.join(beyond)}."


def _background_note(direction: str, chosen: Background | None) -> str:
    if chosen is None:
        return f"{direction}: no background was measured; the noise of the bench counts as emission."
    held = " It was measured with the motor powered: noise of the driver is subtracted too." * (chosen.state == HOLDING)
    return f'{direction}: the background "{chosen.name}" ({chosen.state}) is subtracted.{held}'


def _stretches(record: CampaignRecord, data: Record) -> Iterator[tuple[slice, float]]:
    """Yield the parts of a record that are judged by themselves, each with its step rate in full steps/s."""
    drive = Drive(command=record.command, time_offset_s=record.time_offset.value)
    if not drive.is_stepped:
        yield slice(0, data.samples), np.nan
        return
    base = TimeBase(data.sample_rate_hz, data.samples, data.time_start_s)
    rate = commanded_rate(record.command.rate, drive.time_offset_s, base)
    if len(rate) == 1:
        yield slice(0, data.samples), float(rate[0, 1])
        return
    size = max(round(EMISSION.stretch_s * data.sample_rate_hz), LEAST_SAMPLES)
    # A rest shorter than a stretch is left out: it would have shorter windows and wider bins.
    for first in range(0, max(data.samples - size, 0) + 1, size):
        middle = data.time_start_s + (first + 0.5 * size) / data.sample_rate_hz
        yield slice(first, first + size), float(np.interp(middle, rate[:, 0], rate[:, 1]))


def _source(data: Record, state: str, rates: tuple[float, ...]) -> SourceFile:
    return SourceFile(
        name=data.name,
        file=str(data.path),
        sha256=data.digest,
        state=state,
        sample_rate_hz=data.sample_rate_hz,
        duration_s=data.duration_s,
        rates=rates,
        started=data.start_time or "",
    )


def _group_bins(name: str, rate: float, direction: str, spectra: Spectra) -> EmissionSpectrum:
    starts = peak_groups(spectra.density.size, EMISSION.groups)
    middle = (starts + np.append(starts[1:], spectra.density.size) - 1) // 2
    # The largest bin of each group is kept, so that no line disappears between the points of a figure.
    density = np.maximum.reduceat(spectra.density, starts)
    return EmissionSpectrum(
        record=name,
        rate=rate,
        direction=direction,
        unit=unit_of(direction, AMPLITUDE),
        bin_hz=spectra.bin_hz,
        frequency_hz=middle * spectra.bin_hz,
        amplitude=np.sqrt(density * spectra.peak_scale),
        density=density,
        rms=float(np.sqrt(spectra.density[spectra.usable_bins()].sum() * spectra.bin_hz)),
    )
