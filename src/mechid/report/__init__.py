"""What is shown of a campaign or a fit: every number in one plain dict, then ink.

`report_data` and `campaign_data` make the dict, `print_report` and `print_campaign` the ink of a terminal.
`mechid.report.writing` makes page and figures; it is imported where it is used, for its libraries take their time.
"""

from mechid.report.channels import file_data, print_file
from mechid.report.overview import campaign_data, print_campaign
from mechid.report.results import read_truth, write_results
from mechid.report.tables import report_data
from mechid.report.terminal import print_report

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
