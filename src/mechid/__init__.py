"""Identify the model of a stepper-driven pointing mechanism from torque-transducer records.

The public names load what they need when they are first used, so that importing mechid costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mechid.analysis.comparison import compare
    from mechid.analysis.validation import validate
    from mechid.campaign.campaign_file import load_campaign
    from mechid.campaign.prediction import simulate
    from mechid.exports.export import export
    from mechid.fleets.fleet import fleet
    from mechid.identification.diagnosis.completion import identify
    from mechid.identification.diagnosis.diagnosis import diagnose
    from mechid.identification.result.fit import Fit
    from mechid.simulation.trajectory import Trajectory

__version__ = "0.1.0"
__all__ = [
    "Fit",
    "Trajectory",
    "__version__",
    "compare",
    "diagnose",
    "export",
    "fleet",
    "identify",
    "load_campaign",
    "simulate",
    "validate",
]

_HOMES = {
    "Fit": "mechid.identification.result.fit",
    "Trajectory": "mechid.simulation.trajectory",
    "compare": "mechid.analysis.comparison",
    "diagnose": "mechid.identification.diagnosis.diagnosis",
    "export": "mechid.exports.export",
    "fleet": "mechid.fleets.fleet",
    "identify": "mechid.identification.diagnosis.completion",
    "load_campaign": "mechid.campaign.campaign_file",
    "simulate": "mechid.campaign.prediction",
    "validate": "mechid.analysis.validation",
}


def __getattr__(name: str) -> object:
    """Return a public name, its home imported."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value: object = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
