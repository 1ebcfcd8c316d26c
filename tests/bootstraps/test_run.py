"""A bootstrap from Python. Truth: the memory that the draws would take."""

import pytest

from mechid.bootstraps.run import bootstrap
from mechid.errors import UsageError


def test_more_draws_than_memory_holds_are_refused():
    """By the function that the command calls, so that scripts are refused too."""
    with pytest.raises(UsageError, match=r"99999999999 draws; 1000000 at most"):
        bootstrap("fit", 99999999999)
