"""Which effects a diagnosis looks for: all that the library knows, or those that the campaign file names."""

from __future__ import annotations

from collections.abc import Collection

from mechid.campaign import Campaign
from mechid.campaign.diagnose_options import CONSIDER, DIAGNOSE
from mechid.errors import InputFileError, did_you_mean


def considered(campaign: Campaign, known: Collection[str]) -> frozenset[str]:
    """Return the names of the effects that are looked for.

    A name without what tells its kind apart, as ``"stepper.detent"``, stands for all of that kind.

    Raises
    ------
    InputFileError
        The campaign file names one that is not known.
    """
    chosen: set[str] = set()
    for index, name in enumerate(campaign.considered):
        of_kind = {one for one in known if name in (one, one.partition(":")[0])}
        if not of_kind:
            near = did_you_mean(name, known) or f"; there are {', '.join(sorted(known))}"
            place = f"{campaign.path.name}: {DIAGNOSE}.{CONSIDER}[{index}], or --{CONSIDER}"
            raise InputFileError(f'{place}: found "{name}", which no effect is called here{near}')
        chosen |= of_kind
    return frozenset(chosen if campaign.considered else known)
