"""What is shown of a campaign or a fit: every number in one plain dict, then ink.

`report_data` and `campaign_data` make the dict, `print_report` and `print_campaign` the ink of a terminal.
`mechid.reports.fit.files` makes page and figures. The names here load what they need when they are first used: the
processes that draw figures import this package for their drawings alone.

Internal to mechid but for the names that docs/python.md lists.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mechid.reports.channels import file_data, print_file
    from mechid.reports.fit.numbers import report_data
    from mechid.reports.fit.results import read_truth, write_results
    from mechid.reports.fit.terminal import print_report
    from mechid.reports.overview import campaign_data, print_campaign

__all__ = [
    "campaign_data",
    "file_data",
    "print_campaign",
    "print_file",
    "print_report",
    "read_truth",
    "report_data",
    "write_results",
]

_HOMES = {
    "campaign_data": "overview",
    "file_data": "channels",
    "print_campaign": "overview",
    "print_file": "channels",
    "print_report": "fit.terminal",
    "read_truth": "fit.results",
    "report_data": "fit.numbers",
    "write_results": "fit.results",
}


def __getattr__(name: str) -> object:
    """Return a public name, its home imported."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value: object = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value
