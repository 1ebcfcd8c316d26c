"""A finished fit refitted, from Python. Truth: the memory that the draws would take."""

import pytest

from mechid.errors import UsageError
from mechid.interface.refits import bootstrap


def test_more_draws_than_memory_holds_are_refused():
    """By the function that the command calls, so that scripts are refused too."""
    with pytest.raises(UsageError, match=r"99999999999 draws; 1000000 at most"):
        bootstrap("fit", 99999999999)
