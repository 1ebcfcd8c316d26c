"""What the simulation's tests share."""

import pytest


@pytest.fixture
def note(record_property):
    """Return a function that keeps a figure with the test's result, and prints it (see it with -s)."""

    def keep(text):
        record_property("figure", text)
        print(text)  # noqa: T201

    return keep
