"""Identify the model of a stepper-driven pointing mechanism from torque-transducer records.

Each command of ``mechid`` is a function here, of values that are read from files or made in code; docs/python.md lists
all public names. The names load what they need when they are first used, so that importing mechid costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mechid.analysis.comparison import Comparison
    from mechid.analysis.survey import Survey
    from mechid.analysis.validation import RecordValidation, Validations, validate
    from mechid.bootstraps.run import bootstrap
    from mechid.budgets.budget import Budget
    from mechid.budgets.run import budget
    from mechid.campaign.campaign import Campaign, CampaignRecord, Stage
    from mechid.campaign.campaign_file import load_campaign
    from mechid.campaign.campaign_in_code import RecordEntry, make_campaign, make_command, make_mechanism, make_record
    from mechid.campaign.campaign_writer import write_campaign
    from mechid.campaign.catalogue import catalogue_mechanism
    from mechid.campaign.identify_options import IdentifyOptions
    from mechid.campaign.mechanism_file import load_mechanism
    from mechid.campaign.mechanism_text import write_mechanism
    from mechid.campaign.prediction import simulate, simulate_all
    from mechid.campaign.templates import new_campaign
    from mechid.checks.run import Understanding, check
    from mechid.command.rate import RateProfile
    from mechid.command.step_timing import paired_steps, shaped_ramp, shaped_rate, staggered_steps
    from mechid.command.stepping import Command
    from mechid.comparisons.run import compare
    from mechid.demos.run import demo
    from mechid.designs.design import Design
    from mechid.designs.design_file import DesignOptions
    from mechid.designs.run import design
    from mechid.diagnoses.run import diagnose
    from mechid.emissions.emission import Emission
    from mechid.emissions.run import emission
    from mechid.errors import FitError, InputFileError, MechidError, RecordError, UsageError, WorkersError
    from mechid.exports.export import Exported
    from mechid.exports.run import export
    from mechid.fits.load import load_fit
    from mechid.fleets.fleet import Fleet
    from mechid.fleets.run import fleet
    from mechid.identification.computation.progress import Progress
    from mechid.identification.diagnosis.diagnosis import Diagnosis
    from mechid.identification.refit.bootstrap import Bootstrap
    from mechid.identification.refit.profile import Profile
    from mechid.identification.result.fit import Fit
    from mechid.identification.result.grade import Grade
    from mechid.identification.result.parameter_estimate import ParameterEstimate
    from mechid.indexes.index import Index
    from mechid.indexes.run import open_results
    from mechid.kernel.generated_text import equations, kernel_source
    from mechid.looks.run import look
    from mechid.parameter import Declaration, Parameter
    from mechid.plant.block import Block
    from mechid.plant.mechanism import Mechanism
    from mechid.profiles.run import Profiles, profile
    from mechid.quiet_drives.design_file import QuietDesign
    from mechid.quiet_drives.quiet_drive import QuietDrive
    from mechid.quiet_drives.run import quiet
    from mechid.records.load import load_record
    from mechid.records.record import Channel, Record
    from mechid.reports.into_folder import Identified
    from mechid.reports.run import identify, identify_into, report
    from mechid.simulation.trajectory import Trajectory
    from mechid.structure.formats import load_structure
    from mechid.structure.linear_system import from_state_space
    from mechid.structure.modes import Modes
    from mechid.structure.response import FrequencyResponse
    from mechid.structure.structure import Structure
    from mechid.web.run import explore

__version__ = "0.1.0"
_NAMES = {
    "analysis.comparison": ("Comparison",),
    "analysis.survey": ("Survey",),
    "analysis.validation": ("RecordValidation", "Validations", "validate"),
    "bootstraps.run": ("bootstrap",),
    "budgets.budget": ("Budget",),
    "budgets.run": ("budget",),
    "campaign.campaign": ("Campaign", "CampaignRecord", "Stage"),
    "campaign.campaign_file": ("load_campaign",),
    "campaign.catalogue": ("catalogue_mechanism",),
    "campaign.identify_options": ("IdentifyOptions",),
    "campaign.campaign_in_code": ("RecordEntry", "make_campaign", "make_command", "make_mechanism", "make_record"),
    "campaign.campaign_writer": ("write_campaign",),
    "campaign.mechanism_file": ("load_mechanism",),
    "campaign.mechanism_text": ("write_mechanism",),
    "campaign.prediction": ("simulate", "simulate_all"),
    "campaign.templates": ("new_campaign",),
    "checks.run": ("Understanding", "check"),
    "command.rate": ("RateProfile",),
    "command.step_timing": ("paired_steps", "shaped_ramp", "shaped_rate", "staggered_steps"),
    "command.stepping": ("Command",),
    "comparisons.run": ("compare",),
    "demos.run": ("demo",),
    "designs.design": ("Design",),
    "designs.design_file": ("DesignOptions",),
    "designs.run": ("design",),
    "diagnoses.run": ("diagnose",),
    "emissions.emission": ("Emission",),
    "emissions.run": ("emission",),
    "errors": ("FitError", "InputFileError", "MechidError", "RecordError", "UsageError", "WorkersError"),
    "exports.export": ("Exported",),
    "exports.run": ("export",),
    "fits.load": ("load_fit",),
    "fleets.fleet": ("Fleet",),
    "fleets.run": ("fleet",),
    "identification.computation.progress": ("Progress",),
    "identification.diagnosis.diagnosis": ("Diagnosis",),
    "identification.refit.bootstrap": ("Bootstrap",),
    "identification.refit.profile": ("Profile",),
    "identification.result.fit": ("Fit",),
    "identification.result.grade": ("Grade",),
    "identification.result.parameter_estimate": ("ParameterEstimate",),
    "indexes.index": ("Index",),
    "indexes.run": ("open_results",),
    "kernel.generated_text": ("equations", "kernel_source"),
    "looks.run": ("look",),
    "parameter": ("Declaration", "Parameter"),
    "plant.block": ("Block",),
    "plant.mechanism": ("Mechanism",),
    "profiles.run": ("Profiles", "profile"),
    "quiet_drives.design_file": ("QuietDesign",),
    "quiet_drives.quiet_drive": ("QuietDrive",),
    "quiet_drives.run": ("quiet",),
    "records.load": ("load_record",),
    "records.record": ("Channel", "Record"),
    "reports.into_folder": ("Identified",),
    "reports.run": ("identify", "identify_into", "report"),
    "simulation.trajectory": ("Trajectory",),
    "structure.formats": ("load_structure",),
    "structure.linear_system": ("from_state_space",),
    "structure.modes": ("Modes",),
    "structure.response": ("FrequencyResponse",),
    "structure.structure": ("Structure",),
    "web.run": ("explore",),
}
"""The public names, by the module that defines them."""
_HOMES = {name: module for module, names in _NAMES.items() for name in names}

__all__ = [
    "Block",
    "Bootstrap",
    "Budget",
    "Campaign",
    "CampaignRecord",
    "Channel",
    "Command",
    "Comparison",
    "Declaration",
    "Design",
    "DesignOptions",
    "Diagnosis",
    "Emission",
    "Exported",
    "Fit",
    "FitError",
    "Fleet",
    "FrequencyResponse",
    "Grade",
    "Identified",
    "IdentifyOptions",
    "Index",
    "InputFileError",
    "Mechanism",
    "MechidError",
    "Modes",
    "Parameter",
    "ParameterEstimate",
    "Profile",
    "Profiles",
    "Progress",
    "QuietDesign",
    "QuietDrive",
    "RateProfile",
    "Record",
    "RecordEntry",
    "RecordError",
    "RecordValidation",
    "Stage",
    "Structure",
    "Survey",
    "Trajectory",
    "Understanding",
    "UsageError",
    "Validations",
    "WorkersError",
    "__version__",
    "bootstrap",
    "budget",
    "catalogue_mechanism",
    "check",
    "compare",
    "demo",
    "design",
    "diagnose",
    "emission",
    "equations",
    "explore",
    "export",
    "fleet",
    "from_state_space",
    "identify",
    "identify_into",
    "kernel_source",
    "load_campaign",
    "load_fit",
    "load_mechanism",
    "load_record",
    "load_structure",
    "look",
    "make_campaign",
    "make_command",
    "make_mechanism",
    "make_record",
    "new_campaign",
    "open_results",
    "paired_steps",
    "profile",
    "quiet",
    "report",
    "shaped_ramp",
    "shaped_rate",
    "simulate",
    "simulate_all",
    "staggered_steps",
    "validate",
    "write_campaign",
    "write_mechanism",
]


def __getattr__(name: str) -> object:
    """Return a public name, its home imported."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value: object = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
