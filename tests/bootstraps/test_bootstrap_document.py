"""What is shown of a bootstrap. Truth: draws by hand, two parameters that go together and a phase about 180 deg."""

import numpy as np
import pytest

from mechid.bootstraps.document import PRESENTER
from mechid.bootstraps.figures import PAIRS_NAME, SCATTER_NAME, bootstrap_figures, closest_pairs, draws_in_sigmas
from mechid.bootstraps.numbers import bootstrap_numbers
from mechid.identification.refit.bootstrap import Bootstrap, Draw, DrawOutcome, Spread

DRAWS = 20
PHASE = "stepper.detent.0.phase_deg"


def bootstrap(draws=DRAWS):
    """Return a bootstrap whose inertia and stiffness rise together, the last draw failed."""
    steps = np.linspace(-1.9, 1.9, draws)
    made = [
        Draw(
            k,
            DrawOutcome.CONVERGED,
            1.0,
            {
                "load.inertia": 2.0 + 0.1 * x,
                "gear.stiffness": 900.0 + 3.0 * x,
                PHASE: (359.5 + x) % 360.0 - 180.0,
            },
        )
        for k, x in enumerate(steps)
    ]
    failed = Draw(draws, DrawOutcome.FAILED, float("nan"), dict.fromkeys(made[0].values, float("nan")))
    spreads = (
        Spread("load.inertia", "kg m^2", 2.0, 0.1, 0.0, 0.11, (1.8, 2.2)),
        Spread("gear.stiffness", "N m/rad", 900.0, 3.0, 0.0, 3.3, (894.3, 905.7)),
        Spread(PHASE, "deg", 179.5, 1.0, 0.0, 1.1, (177.6, 181.4)),
    )
    return Bootstrap(draws=(*made, failed), spreads=spreads, noise={}, seed=3)


def test_files_and_page_have_the_scatter(tmp_path):
    found = bootstrap()
    names = {path.name for path in PRESENTER.write(found, PRESENTER.numbers(found), tmp_path)}
    assert names == {"bootstrap.json", "bootstrap.csv", "bootstrap.md", "bootstrap.html", "figures"}
    assert {path.stem for path in (tmp_path / "figures").iterdir()} == {SCATTER_NAME, PAIRS_NAME}
    page, markdown = ((tmp_path / name).read_text() for name in ("bootstrap.html", "bootstrap.md"))
    for text in (page, markdown, PRESENTER.text(found)):
        assert "894.3" in text
        assert "1 of 21 refits could not be simulated" in text
    assert page.count("<svg") == 2
    assert "21 draws, seed 3" in page


def test_draws_are_in_standard_errors_and_angles_go_the_short_way():
    """Truth: the steps from which the draws were made; the failed one is left out."""
    draws = draws_in_sigmas(bootstrap_numbers(bootstrap(), 3))
    for own in draws.values():
        assert own == pytest.approx(np.linspace(-1.9, 1.9, DRAWS))


def test_pairs_that_go_together_are_drawn_where_draws_tell_them():
    """Truth: all three rise together; of five draws chance may make that."""
    assert len(closest_pairs(bootstrap_numbers(bootstrap(), 3))) == 3
    few = bootstrap_numbers(bootstrap(5), 3)
    assert closest_pairs(few) == []
    assert [name for name, _ in bootstrap_figures(few)] == [SCATTER_NAME]
