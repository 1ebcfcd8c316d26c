"""Public function that judges the emission at the interface against its specification."""

from __future__ import annotations

from pathlib import Path

from mechid.emissions.assessor import Assessor
from mechid.emissions.declared import load_declared
from mechid.emissions.emission import Emission
from mechid.identification.computation.parallel import one_core_algebra


def emission(campaign: Path | str, *, requirements: Path | str | None = None) -> Emission:
    """Judge the exported forces and torques of a campaign's records against requirements, without any model.

    Parameters
    ----------
    campaign : Path
        Campaign file, or the folder that holds ``campaign.toml``, with ``[[record]]`` and ``[[background]]`` tables.
        The mechanism file need not be there.
    requirements : Path or None
        File with the ``[[requirement]]`` tables; None takes those of the campaign file.

    Returns
    -------
    Emission
        A verdict for each requirement (pass, fail, not shown, not decidable), all lines, spectra over the rates.

    Raises
    ------
    InputFileError
        A file is wrong, or a requirement asks for a direction that no record has.
    RecordError
        A record or a background is missing or cannot be used.

    Examples
    --------
    >>> import mechid
    >>> mechid.emission("bench").passes  # doctest: +SKIP
    True
    """
    with one_core_algebra():
        declared = load_declared(Path(campaign), Path(requirements) if requirements is not None else None)
        assessor = Assessor(declared)
        for record in declared.read():
            assessor.add(record)
        return assessor.result()
