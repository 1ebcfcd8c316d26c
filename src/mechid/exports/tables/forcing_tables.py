"""Tables of the torque on the base: lines, third octaves, and motion at each rate."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.budgets.emission import Emission, line_sigmas, phase_sigmas
from mechid.budgets.flying_mechanism import Estimate
from mechid.budgets.settings import LEVEL
from mechid.budgets.steady_state import SteadyState
from mechid.exports.forcing import Forcing
from mechid.exports.tables.table import Column, Table, numbers, texts

LINES, BANDS, RATES = "lines", "bands", "rates"
SHARE = f"{100.0 * LEVEL.bound:g} %"


@dataclass(frozen=True, eq=False)
class _AtRate:
    """One rate of a forcing."""

    forcing: Forcing
    tested: bool
    state: SteadyState
    emission: Emission
    motions: int


def forcing_tables(forcings: Sequence[Forcing], estimate: Estimate) -> tuple[Table, ...]:
    """Return the tables of lines, bands and rates of all stepping modes."""
    every = [at for one in forcings for at in _at_rates(one)]
    return (_lines(every, estimate), _bands(every), _rates(every, estimate))


def _at_rates(forcing: Forcing) -> Iterator[_AtRate]:
    tested = forcing.stepping.covers(forcing.mode.rates).tolist()
    every = zip(tested, forcing.largest, forcing.emissions, forcing.states, strict=True)
    for inside, state, exerted, states in every:
        yield _AtRate(forcing, inside, state, exerted, len(states))


def _key_columns(every: Sequence[_AtRate], count: Callable[[_AtRate], int]) -> tuple[Column, ...]:
    """Return the key columns of a table, repeated for the number of rows at each rate."""
    counts = [count(at) for at in every]
    names = np.repeat(np.array([at.forcing.stepping.name for at in every]), counts)
    rates = np.repeat([at.state.rate for at in every], counts)
    return (
        texts("stepping", "way of stepping, with its microsteps in a full step", [str(name) for name in names]),
        numbers("rate_steps_per_s", "1/s", "commanded rate, full steps a second", rates),
    )


def _lines(every: Sequence[_AtRate], estimate: Estimate) -> Table:
    """Return the table of lines at each rate: those of the model, then residual lines, without a phase."""

    def of_lines(of_state: Callable[[SteadyState], Any], beside: float = np.nan) -> FloatArray:
        """Return a value of the modelled lines, and `beside` for the residual lines after them."""
        parts = [(np.asarray(of_state(at.state)), at.emission.orders.size) for at in every]
        filled = [np.concatenate([own, np.full(size - own.size, beside)]) for own, size in parts]
        return np.concatenate(filled) if filled else np.zeros(0)

    def of_emissions(of_emission: Callable[[Emission], Any]) -> FloatArray:
        return np.concatenate([np.asarray(of_emission(at.emission)) for at in every])

    amplitude = of_lines(lambda s: np.abs(s.lines), 0.0)
    phase = of_lines(lambda s: np.degrees(np.angle(s.lines)))
    sigma = of_lines(lambda s: line_sigmas(estimate, s))
    phase_sigma = of_lines(lambda s: np.degrees(phase_sigmas(estimate, s)))
    residual, bound = of_emissions(lambda e: e.residual), of_emissions(lambda e: e.bound)
    carried = list(chain.from_iterable(at.emission.transfer_rules for at in every))
    columns = (
        *_key_columns(every, lambda at: at.emission.orders.size),
        numbers("order", "1", "frequency over the rate", of_emissions(lambda e: e.orders)),
        numbers("frequency_Hz", "Hz", "order times rate", of_emissions(lambda e: e.frequency_hz)),
        numbers("amplitude_Nm", "N m", "peak amplitude of the model's line; 0 where it has none", amplitude),
        numbers("phase_deg", "deg", "of Re(line e^(i 2 pi f t)), t from the start of a period, at a step", phase),
        numbers("sigma_Nm", "N m", "standard error of the amplitude", sigma),
        numbers("phase_sigma_deg", "deg", "standard error of the phase", phase_sigma),
        numbers("error_Nm", "N m", "numerical error of the line, part of sigma", of_lines(lambda s: s.error)),
        numbers(
            "residual_Nm", "N m", "what the model lacks of the line, by what the fit left of the records", residual
        ),
        numbers("bound_Nm", "N m", f"the amplitude is below with {SHARE}: model, its errors and what it lacks", bound),
        texts("residual_carried", "how sure the way of the residual to the base is", carried),
    )
    return Table(LINES, columns)


def _bands(every: Sequence[_AtRate]) -> Table:
    def of(name: str) -> FloatArray:
        return np.concatenate([np.asarray(getattr(at.emission, name)) for at in every])

    edges = of("bands_hz")
    return Table(
        BANDS,
        (
            *_key_columns(every, lambda at: len(at.emission.bands_hz)),
            numbers("from_Hz", "Hz", "lower edge of the third octave", edges[:, 0]),
            numbers("to_Hz", "Hz", "upper edge", edges[:, 1]),
            numbers("modelled_rms_Nm", "N m", "RMS of the model's lines in it", of("band_modelled")),
            numbers("residual_rms_Nm", "N m", "RMS of what the model lacks", of("band_residual")),
            numbers("bound_rms_Nm", "N m", f"the RMS is below with {SHARE}", of("band_bound")),
        ),
    )


def _rates(every: Sequence[_AtRate], estimate: Estimate) -> Table:
    def outside(at: _AtRate) -> float:
        source = estimate.residual
        return np.nan if source is None else source.at(at.forcing.mode.command, at.state.rate).outside

    def of(name: str) -> list[Any]:
        return [getattr(at.state, name) for at in every]

    repeats = [at.state.steps * at.state.periods for at in every]
    motions, beyond = [at.motions for at in every], [outside(at) for at in every]
    columns = (
        *_key_columns(every, lambda _: 1),
        numbers("tested", "1", "1: a record of this stepping ran at this rate", [at.tested for at in every]),
        numbers("torque_rms_Nm", "N m", "RMS of the whole torque about its mean", of("rms")),
        numbers("torque_rms_error_Nm", "N m", "its standard error where the motion does not repeat", of("rms_error")),
        numbers("repeats_after_steps", "1", "full steps after which the motion repeats; 0: it does not", repeats),
        numbers("decay_s", "s", "time in which the slowest transient falls to 1/e", of("decay_s")),
        numbers("follows", "1", "1: the rotor keeps up with the command", of("follows")),
        numbers("motions", "1", "motions found at this rate; the one with the largest RMS counts", motions),
        numbers("residual_outside", "1", "1: what the model lacks was measured at no rate near this one", beyond),
        texts("reached", "how that motion was reached", [" and ".join(reached) for reached in of("reached")]),
    )
    return Table(RATES, columns)
