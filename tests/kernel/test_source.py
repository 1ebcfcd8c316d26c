"""The generated kernel as text: a change of it is seen, line by line, before it is believed.

The text is what `mechid kernel --source` prints. It is no truth: that the equations are right is shown by the tests
against hand-typed right-hand sides, the twin and published numbers. It guards what a rearrangement of plant or
generator must not move, and shows what a change of equations does move.
"""

from pathlib import Path

import pytest

from golden_text import assert_kept
from golden_variants import NAMES, plant_named
from mechid.kernel.source import generate, lanes_for

FOLDER = Path(__file__).parent / "golden"


@pytest.mark.parametrize("name", NAMES)
def test_the_kernel_s_text_is_the_one_that_is_kept(name, update_golden):
    assert_kept(FOLDER / f"{name}.txt", generate(plant_named(name), lanes_for(0)), update=update_golden)


def test_every_kept_text_belongs_to_a_mechanism():
    assert {path.stem for path in FOLDER.iterdir()} == set(NAMES)


def test_lanes_are_whole_groups_and_a_simulation_s_kernel_serves_a_fit_of_twenty_parameters():
    """Truth: groups of four by hand; twenty, so that check, identify and budget share the kernel of a mechanism."""
    assert {lanes_for(count) for count in (0, 1, 16, 17, 20)} == {20}
    assert [lanes_for(count) for count in (21, 24, 25)] == [24, 24, 28]
