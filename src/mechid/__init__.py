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
    from mechid.budgets.budget import Budget
    from mechid.campaign.campaign import Campaign, CampaignRecord, Stage
    from mechid.campaign.campaign_file import load_campaign
    from mechid.campaign.catalogue import catalogue_mechanism
    from mechid.campaign.identify_options import IdentifyOptions
    from mechid.campaign.in_code import RecordEntry, make_campaign, make_command, make_mechanism, make_record
    from mechid.campaign.in_files import write_campaign
    from mechid.campaign.mechanism_text import write_mechanism
    from mechid.campaign.prediction import simulate, simulate_all
    from mechid.campaign.templates import new_campaign
    from mechid.command.rate import RateProfile
    from mechid.command.stepping import Command
    from mechid.designs.design import Design
    from mechid.designs.design_file import DesignOptions
    from mechid.errors import FitError, InputFileError, MechidError, RecordError, UsageError, WorkersError
    from mechid.exports.export import Exported
    from mechid.fleets.fleet import Fleet
    from mechid.identification.computation.progress import Progress
    from mechid.identification.diagnosis.diagnosis import Diagnosis
    from mechid.identification.refit.bootstrap import Bootstrap
    from mechid.identification.refit.profile import Profile
    from mechid.identification.result.fit import Fit
    from mechid.identification.result.grade import Grade
    from mechid.identification.result.parameter_estimate import ParameterEstimate
    from mechid.indexes.index import Index
    from mechid.indexes.run import open_results
    from mechid.interface.budget import budget
    from mechid.interface.check import Understanding, check
    from mechid.interface.compare import compare
    from mechid.interface.demo import demo
    from mechid.interface.design import design
    from mechid.interface.diagnose import diagnose
    from mechid.interface.equations import equations, kernel_source
    from mechid.interface.explore import explore
    from mechid.interface.export import export
    from mechid.interface.fits import load_fit
    from mechid.interface.fleet import fleet
    from mechid.interface.identification import identify, identify_into
    from mechid.interface.look import look
    from mechid.interface.reading import load_mechanism, load_record, load_structure
    from mechid.interface.refits import Profiles, bootstrap, profile
    from mechid.interface.report import report
    from mechid.parameter import Declaration, Parameter
    from mechid.plant.block import Block
    from mechid.plant.mechanism import Mechanism
    from mechid.records.record import Channel, Record
    from mechid.reports.identified import Identified
    from mechid.simulation.trajectory import Trajectory
    from mechid.structure.linear_system import from_state_space
    from mechid.structure.modes import Modes
    from mechid.structure.response import FrequencyResponse
    from mechid.structure.structure import Structure

__version__ = "0.1.0"
_NAMES = {
    "analysis.comparison": ("Comparison",),
    "analysis.survey": ("Survey",),
    "analysis.validation": ("RecordValidation", "Validations", "validate"),
    "budgets.budget": ("Budget",),
    "campaign.campaign": ("Campaign", "CampaignRecord", "Stage"),
    "campaign.campaign_file": ("load_campaign",),
    "campaign.catalogue": ("catalogue_mechanism",),
    "campaign.identify_options": ("IdentifyOptions",),
    "campaign.in_code": ("RecordEntry", "make_campaign", "make_command", "make_mechanism", "make_record"),
    "campaign.in_files": ("write_campaign",),
    "campaign.mechanism_text": ("write_mechanism",),
    "campaign.prediction": ("simulate", "simulate_all"),
    "campaign.templates": ("new_campaign",),
    "command.rate": ("RateProfile",),
    "command.stepping": ("Command",),
    "designs.design": ("Design",),
    "designs.design_file": ("DesignOptions",),
    "errors": ("FitError", "InputFileError", "MechidError", "RecordError", "UsageError", "WorkersError"),
    "exports.export": ("Exported",),
    "fleets.fleet": ("Fleet",),
    "identification.computation.progress": ("Progress",),
    "identification.diagnosis.diagnosis": ("Diagnosis",),
    "identification.refit.bootstrap": ("Bootstrap",),
    "identification.refit.profile": ("Profile",),
    "identification.result.fit": ("Fit",),
    "identification.result.grade": ("Grade",),
    "identification.result.parameter_estimate": ("ParameterEstimate",),
    "indexes.index": ("Index",),
    "indexes.run": ("open_results",),
    "interface.budget": ("budget",),
    "interface.check": ("Understanding", "check"),
    "interface.compare": ("compare",),
    "interface.demo": ("demo",),
    "interface.design": ("design",),
    "interface.diagnose": ("diagnose",),
    "interface.equations": ("equations", "kernel_source"),
    "interface.explore": ("explore",),
    "interface.export": ("export",),
    "interface.fleet": ("fleet",),
    "interface.fits": ("load_fit",),
    "interface.identification": ("identify", "identify_into"),
    "interface.look": ("look",),
    "interface.reading": ("load_mechanism", "load_record", "load_structure"),
    "interface.refits": ("Profiles", "bootstrap", "profile"),
    "interface.report": ("report",),
    "parameter": ("Declaration", "Parameter"),
    "plant.block": ("Block",),
    "plant.mechanism": ("Mechanism",),
    "records.record": ("Channel", "Record"),
    "reports.identified": ("Identified",),
    "simulation.trajectory": ("Trajectory",),
    "structure.linear_system": ("from_state_space",),
    "structure.modes": ("Modes",),
    "structure.response": ("FrequencyResponse",),
    "structure.structure": ("Structure",),
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
    "profile",
    "report",
    "simulate",
    "simulate_all",
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
