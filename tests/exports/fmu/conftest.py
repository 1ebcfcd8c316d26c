"""The paper's mechanism as a unit, as it flies."""

from dataclasses import replace

import pytest

from mechid.exports.fmu.unit import Unit, with_ports, without_ports


@pytest.fixture(scope="session")
def at_rest(paper):
    """Return what is handed on, its mechanism on a base at rest."""
    return replace(paper, mechanism=without_ports(paper, {}, stand=False))


@pytest.fixture(scope="session")
def of_paper(at_rest):
    """Return the unit with its ports; nothing of it is written or compiled."""
    return Unit(replace(at_rest, mechanism=with_ports(at_rest.mechanism, stand=False)), 1.0)
