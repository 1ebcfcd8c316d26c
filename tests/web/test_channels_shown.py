"""Several channels of a record, looked at. Truth: the noise and the offset that were added to what the twin made."""

import pytest

from channels import NOISE, OFFSET, written
from layouts import mechanism_of, paper_table
from mechid.units import unit_words
from mechid.web import Source
from mechid.web.session import Session
from mechid.web.shown import shown_data


def test_each_channel_is_shown_beside_the_model_in_its_own_unit(tmp_path):
    m = mechanism_of(paper_table())
    truth = {name: m.value(name) for name in ("gear.stiffness", "gear.damping")}
    session = Session(Source(written(tmp_path, m, truth)))
    for name, value in truth.items():
        session.turn(name, value)
    for label, scene in session.scenes.items():
        quantity = scene.match.quantity
        assert label == (scene.record.name if quantity == "torque" else f"{scene.record.name}: {quantity}")
        session.look((label,), 1e9)
        pictures = session.pictures()
        numbers = pictures[label].numbers
        assert numbers.residual.residual_rms == pytest.approx(NOISE[quantity], rel=0.1), label
        assert numbers.offset == pytest.approx(OFFSET[quantity], abs=0.5 * NOISE[quantity] + 1e-3)
        (panel,) = shown_data(session, pictures, session.effects(), {})["records"]
        assert dict(panel["numbers"])["residual"].endswith(unit_words(quantity))
    assert {scene.match.quantity for scene in session.scenes.values()} == set(NOISE)
