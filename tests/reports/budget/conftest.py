"""The small budget as the dict of its numbers, and the files of its report."""

import json

import pytest

from mechid.budgets.numbers import budget_data
from mechid.identification.result.estimate_file import json_text
from mechid.reports.budget.files import write_budget_report
from small_budget import small_budget


@pytest.fixture(scope="session")
def data(tmp_path_factory):
    """Return every number of the small budget; not to be changed."""
    return json.loads(json_text(budget_data(small_budget(tmp_path_factory))))


@pytest.fixture(scope="session")
def folder(data, tmp_path_factory):
    """Return the folder of its report."""
    out = tmp_path_factory.mktemp("report")
    write_budget_report(data, out)
    return out
