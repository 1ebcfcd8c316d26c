"""Loads at the interface: calibrated, freed from the table's response, and moved to the interface point."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign.bench_entry import Bench
from mechid.campaign.table_response_entry import DIRECTIONS
from mechid.emissions.correction import Correction
from mechid.emissions.table_response import SIX
from mechid.emissions.table_response_file import table_response_of
from mechid.errors import RecordError
from mechid.records import Mounting, Record, move_to_mounting_point
from mechid.records.components import COMPONENTS
from mechid.signal.series import Series
from mechid.signal.stored_series import map_samples


@dataclass(frozen=True, eq=False)
class Interface:
    """What makes loads at the interface of the channels of a bench, for runs and backgrounds alike.

    Parameters
    ----------
    bench : Bench

    Raises
    ------
    InputFileError
        The table's response cannot be read, or supports no frequency of the declared band.
    """

    bench: Bench

    @property
    def mounting(self) -> Mounting | None:
        """Drive axis, and the point that moments are about; None without a declared bench."""
        return self.bench.interface

    @cached_property
    def correction(self) -> Correction:
        """Correction of the table."""
        bench = self.bench
        made = Correction(
            response=None if bench.response is None else table_response_of(bench.response),
            calibration_error=bench.calibration.uncertainty if bench.calibration else 0.0,
            band_hz=bench.usable_band_hz or (0.0, np.inf),
        )
        self._refuse_unsupported(made)
        return made

    def _refuse_unsupported(self, made: Correction) -> None:
        if made.response is None:
            if not made.supported_hz[:, 1].all():
                raise (
                    self.bench.place.key("calibration")
                    .key("uncertainty_percent")
                    .error(
                        f"with {100.0 * made.calibration_error:g} % the loads are uncertain by more than 1 dB at all "
                        "frequencies; calibrate the table"
                    )
                )
            return
        assert self.bench.response is not None
        coverage, place = made.response.coverage_hz, self.bench.response.place
        known = ~np.isnan(coverage[:, 0])
        low, high = float(np.max(coverage[known, 0])), float(np.min(coverage[known, 1]))
        declared = self.bench.usable_band_hz
        if self.bench.response.file is not None and declared and (low > declared[0] or high < declared[1]):
            raise place.error(
                f"covers {low:.4g} to {high:.4g} Hz, but usable_band_hz is {declared[0]:.4g} to {declared[1]:.4g} Hz; "
                "measure the response there, or narrow usable_band_hz"
            )
        empty = known & ~(made.applied_hz[:, 1] > made.applied_hz[:, 0])
        if empty.any():
            which = ", ".join(DIRECTIONS[k] for k in np.flatnonzero(empty))
            raise place.error(
                f"supports no frequency in {which}: the correction is uncertain by more than 1 dB from the lowest one "
                "on; check its units and uncertainty_percent"
            )

    def prediction_notes(self) -> Iterator[str]:
        """Yield that a fit knows no other point than the mounting point, where another one is declared."""
        bench = self.bench
        if bench.mounting and bench.interface_point_m not in (None, bench.mounting.point_m):
            yield "Predictions are of the torque about mounting_point_m; interface_point_m applies to records alone."

    @property
    def is_corrected(self) -> bool:
        """Whether a response of the table is taken out."""
        return self.bench.response is not None

    def load(self, record: Record) -> Record:
        """Return a record with its loads at the interface.

        Raises
        ------
        RecordError
            A component is missing that another one is made of.
        """
        if self.mounting is None:
            return record
        record = self.bench.calibrate_record(record)
        if self.is_corrected:
            record = self._correct(record)
        held = {channel.quantity for channel in record.channels}
        for quantity, forces in self.mounting.levers(tuple(held)) if held & set(COMPONENTS) else ():
            if missing := [force for force in forces if force not in held]:
                raise RecordError(
                    f'record "{record.name}": {quantity} about the interface point takes {" and ".join(missing)} too; '
                    "add the channel"
                )
        return move_to_mounting_point(record, self.mounting)

    def _correct(self, record: Record) -> Record:
        assert self.mounting is not None
        at = {k: self.mounting.component(channel.quantity) for k, channel in enumerate(record.channels)}
        place = {k: where for k, where in at.items() if where is not None}
        held = {component for component, _ in place.values()}
        for component in sorted(held):
            needed = set(np.flatnonzero(self.correction.coupled[component]).tolist())
            if missing := sorted(needed - held):
                raise RecordError(
                    f'record "{record.name}": has no {", ".join(COMPONENTS[k] for k in missing)}, which the response '
                    f"of the table couples to {COMPONENTS[component]}; add the channel"
                )
        loads: dict[int, Series] = {
            component: _times(record.channels[k].data, sign) for k, (component, sign) in place.items()
        }
        found = self.correction.filter_loads(loads, record.sample_rate_hz)
        channels = tuple(
            replace(channel, data=_times(found[place[k][0]], place[k][1])) if k in place else channel
            for k, channel in enumerate(record.channels)
        )
        treatment = {"step": "table", "text": "response of the table taken out by its regularised inverse"}
        return replace(record, channels=channels, treatments=(*record.treatments, treatment))

    @cached_property
    def _lever(self) -> FloatArray:
        """Loads about the interface point per load about the table's reference point, (6, 6)."""
        lever = np.eye(SIX)
        if self.mounting is not None:
            for axis in range(3):
                for force, arm in self.mounting.lever(axis).items():
                    lever[3 + axis, COMPONENTS.index(force)] = -arm
        return lever

    def band_hz(self, direction: str) -> tuple[float, float]:
        """Return the band in which a direction may be judged: those of all loads that it is made of."""
        if self.mounting is None or direction not in DIRECTIONS:
            return self.bench.usable_band_hz or (0.0, np.inf)
        rows = np.flatnonzero(self._lever[DIRECTIONS.index(direction)])
        band = self.correction.applied_hz[rows]
        return float(band[:, 0].max()), float(band[:, 1].min())

    @property
    def is_uncertain(self) -> bool:
        """Whether calibration or response have a standard error."""
        return self.mounting is not None and (self.is_corrected or self.correction.calibration_error > 0.0)

    def error_density(
        self, direction: str, frequency_hz: FloatArray, densities: Mapping[str, FloatArray]
    ) -> FloatArray | None:
        """Return the density of the error that calibration and response leave in a direction, (M,); None if none.

        Parameters
        ----------
        direction : str
        frequency_hz : ndarray, shape (M,)
        densities : mapping of str to ndarray, shape (M,)
            Of each direction that was measured, at the interface.
        """
        if not self.is_uncertain or direction not in DIRECTIONS:
            return None
        back = np.linalg.inv(self._lever) ** 2
        own = np.stack([densities.get(one, np.zeros(frequency_hz.size)) for one in DIRECTIONS], axis=1)
        # Moments are moved by forces: the loads as measured are those at the interface and what the move took away.
        measured = own @ back.T
        total = np.zeros(frequency_hz.size)
        for k in np.flatnonzero(self._lever[DIRECTIONS.index(direction)]):
            share = self._lever[DIRECTIONS.index(direction), k] ** 2
            total += share * np.sum(self.correction.error_variance(frequency_hz, int(k)) * measured, axis=1)
        return total


def _times(series: Series, sign: float) -> Series:
    return series if sign == 1.0 else map_samples(series, lambda values, _: sign * values)
