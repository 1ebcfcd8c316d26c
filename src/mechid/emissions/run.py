"""Public function that judges the emission at the interface against its specification."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from mechid.emissions.assessor import Assessor
from mechid.emissions.declared import load_declared
from mechid.emissions.emission import Emission, with_prediction
from mechid.emissions.predicted import BENCH, FLIGHT, estimate_for, predict_emission
from mechid.errors import UsageError
from mechid.identification.computation.parallel import one_core_algebra
from mechid.identification.result.fit import Fit


def emission(
    campaign: Path | str,
    *,
    requirements: Path | str | None = None,
    fit: Fit | Path | str | None = None,
    flight: Path | str | None = None,
) -> Emission:
    """Judge the forces and torques of a campaign's records against requirements, without any model or with a fit.

    Parameters
    ----------
    campaign : Path
        Campaign file, or the folder that holds ``campaign.toml``, with ``[[record]]`` and ``[[background]]`` tables.
        The mechanism file need not be there.
    requirements : Path or None
        File with the ``[[requirement]]`` tables; None takes those of the campaign file.
    fit : Fit, Path or None
        Fit that predicts the torque at all rates of the range: one that holds its campaign, or a result folder. None
        judges the records alone.
    flight : Path or None
        File with a ``[flight]`` table, as BUDGET.toml: the prediction is that on the base in flight. None predicts with
        the values of the bench, at its transducer.

    Returns
    -------
    Emission
        A verdict for each requirement (pass, fail, not shown, not decidable), all lines, spectra over the rates.

    Raises
    ------
    InputFileError
        A file is wrong, a requirement asks for a direction that no record has, or the fit has failed.
    RecordError
        A record or a background is missing or cannot be used.
    UsageError
        ``flight`` without a fit, or no record is driven by steps.
    FitError
        The predicted mechanism diverged.

    Examples
    --------
    >>> import mechid
    >>> mechid.emission("bench").passes  # doctest: +SKIP
    True
    """
    if flight is not None and fit is None:
        raise UsageError("--flight: says at which values a fit predicts; give the fit too, with --fit DIR")
    with one_core_algebra():
        declared = load_declared(Path(campaign), Path(requirements) if requirements is not None else None)
        estimate = None if fit is None else estimate_for(fit, flight)
        assessor = Assessor(declared)
        for record in declared.read():
            assessor.add(record)
        found = assessor.result()
        if estimate is None or fit is None:
            return found
        predicted = predict_emission(
            estimate,
            declared.requirements,
            assessor.trials,
            found.lines,
            declared.mounting,
            place=BENCH if flight is None else FLIGHT,
            source="a fit in memory" if isinstance(fit, Fit) else str(fit),
        )
        found = replace(found, notes=(*found.notes, *declared.interface.prediction_notes()))
        return with_prediction(found, predicted)
