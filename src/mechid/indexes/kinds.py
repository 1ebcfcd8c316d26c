"""Kinds of result in an index: their file, page and verdict."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from mechid.indexes import verdicts
from mechid.indexes.verdicts import Judged
from mechid.ink.sheet import FOLDER_NAME


@dataclass(frozen=True, kw_only=True)
class Kind:
    """Kind of result.

    Attributes
    ----------
    heading : str
    file : str
        Name of the file with its numbers.
    format : str
        Value of ``format`` in that file; empty for a file written by users.
    verdict : callable
        Derives the verdict from the numbers.
    page : str
        Name of its page, in the folder of the file.
    picture : str
        Pattern in the names of its figures, of which the first is shown; empty for none.
    figure_folder : str
        Folder of the figures, relative to the file; empty for the same folder.
    """

    heading: str
    file: str
    format: str
    verdict: Judged
    page: str = ""
    picture: str = ""
    figure_folder: str = FOLDER_NAME


CAMPAIGNS, CHECKS, FITS, LOOKS, SIMULATIONS = ("Campaigns", "Checks", "Fits", "Looks", "Simulations")
KINDS: tuple[Kind, ...] = (
    Kind(heading=CAMPAIGNS, file="campaign.toml", format="", verdict=verdicts.campaign_verdict),
    Kind(
        heading=CHECKS,
        file="check.json",
        format="mechid-check/1",
        verdict=verdicts.check_verdict,
        page="check.html",
        picture="_spectrum",
        figure_folder="",
    ),
    Kind(
        heading=LOOKS,
        file="look.json",
        format="mechid-look/1",
        verdict=verdicts.look_verdict,
        page="look.html",
        picture="_spectrum",
    ),
    Kind(
        heading=FITS,
        file="estimate.json",
        format="mechid-estimate/1",
        verdict=verdicts.fit_verdict,
        page="report.html",
        picture="_torque",
    ),
    Kind(
        heading="Diagnoses",
        file="diagnose.json",
        format="mechid-diagnosis/1",
        verdict=verdicts.diagnosis_verdict,
        page="diagnose.html",
        picture="diagnosis_",
    ),
    Kind(
        heading="Comparisons",
        file="comparison.json",
        format="mechid-comparison/1",
        verdict=verdicts.comparison_verdict,
        page="comparison.html",
        picture="comparison_records",
    ),
    Kind(
        heading="Profiles",
        file="profile.json",
        format="mechid-profile/1",
        verdict=verdicts.profile_verdict,
        page="profile.html",
        picture="profile_",
    ),
    Kind(
        heading="Bootstraps",
        file="bootstrap.json",
        format="mechid-bootstrap/1",
        verdict=verdicts.bootstrap_verdict,
        page="bootstrap.html",
        picture="bootstrap_",
    ),
    Kind(
        heading="Designs",
        file="design.json",
        format="mechid-design/1",
        verdict=verdicts.design_verdict,
        page="design.html",
        picture="standard_errors",
    ),
    Kind(
        heading="Quiet drives",
        file="quiet.json",
        format="mechid-quiet/1",
        verdict=verdicts.quiet_verdict,
        page="quiet.html",
        picture="quiet_rates",
    ),
    Kind(
        heading="Budgets",
        file="budget.json",
        format="mechid-budget/1",
        verdict=verdicts.budget_verdict,
        page="budget.html",
        picture="budget_requirements",
    ),
    Kind(
        heading="Emissions",
        file="emission.json",
        format="mechid-emission/1",
        verdict=verdicts.emission_verdict,
        page="emission.html",
        picture="emission_",
    ),
    Kind(
        heading="Fleets",
        file="fleet.json",
        format="mechid-fleet/1",
        verdict=verdicts.fleet_verdict,
        page="fleet.html",
        picture="fleet_",
    ),
    Kind(
        heading=SIMULATIONS,
        file="simulate.json",
        format="mechid-simulation/1",
        verdict=verdicts.simulation_verdict,
        page="simulate.html",
        picture="simulated_",
    ),
    Kind(
        heading="Exports",
        file="mechid_export.json",
        format="mechid-export/1",
        verdict=verdicts.export_verdict,
        page="mechid_export.html",
    ),
)
BY_FILE: Mapping[str, Kind] = {kind.file: kind for kind in KINDS}
