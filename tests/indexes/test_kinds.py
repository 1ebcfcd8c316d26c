"""The kinds of result that an index knows. Truth: the modules that write them."""

from importlib import import_module

import pytest

from mechid.bootstraps import numbers as bootstraps
from mechid.budgets import files as budget_files
from mechid.budgets import numbers as budgets
from mechid.campaign import campaign_file
from mechid.checks import numbers as checks
from mechid.comparisons import numbers as comparisons
from mechid.designs import numbers as designs
from mechid.designs import sentences
from mechid.display import DOCUMENTS
from mechid.emissions import document as emission_document
from mechid.emissions import numbers as emissions
from mechid.exports import export as exports
from mechid.fleets import files as fleet_files
from mechid.fleets import numbers as fleets
from mechid.identification.result import diagnosis_file, fit
from mechid.indexes.kinds import KINDS
from mechid.looks import document as look_document
from mechid.looks import numbers as looks
from mechid.profiles import numbers as profiles
from mechid.quiet_drives import numbers as quiet_drives
from mechid.simulations import numbers as simulations

WRITTEN = {
    "Campaigns": (campaign_file.FILE_NAME, ""),
    "Checks": (checks.FILE_NAME, checks.FORMAT),
    "Fits": (fit.ESTIMATE_NAME, fit.FORMAT),
    "Diagnoses": (diagnosis_file.FILE_NAME, diagnosis_file.FORMAT),
    "Comparisons": (comparisons.FILE_NAME, comparisons.FORMAT),
    "Profiles": (profiles.FILE_NAME, profiles.FORMAT),
    "Bootstraps": (bootstraps.FILE_NAME, bootstraps.FORMAT),
    "Designs": (sentences.JSON_NAME, designs.FORMAT),
    "Quiet drives": (quiet_drives.FILE_NAME, quiet_drives.FORMAT),
    "Budgets": (budget_files.JSON, budgets.FORMAT),
    "Emissions": (emission_document.JSON_NAME, emissions.FORMAT),
    "Fleets": (fleet_files.JSON_NAME, fleets.FORMAT),
    "Exports": (exports.FILE_NAME, exports.FORMAT),
    "Simulations": (simulations.FILE_NAME, simulations.FORMAT),
    "Looks": (look_document.JSON_NAME, looks.FORMAT),
}


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.heading)
def test_a_kind_is_found_by_what_its_command_writes(kind):
    assert (kind.file, kind.format) == WRITTEN[kind.heading]


def test_every_page_of_a_result_has_its_kind():
    """Truth: the presenters; the page of a fit is a writer's own, as its figures are drawn while it is fitted."""
    names = {import_module(module).PRESENTER.name for module in DOCUMENTS.values()}
    assert {kind.page for kind in KINDS if kind.page} == {"report.html", *(f"{name}.html" for name in names if name)}
