"""Several channels of a record, looked at. Truth: the noise and the offset that were added to what the twin made."""

import json

import pytest

from channels import NOISE, OFFSET, written
from layouts import mechanism_of, paper_table
from mechid.units import unit_words
from mechid.web import Source
from mechid.web.page_content import page_data, shown_data
from mechid.web.session import Session
from turned import at_truth


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


def test_what_the_page_says_is_plain_json_with_the_numbers_of_the_pictures(session, campaign):
    at_truth(session)
    pictures = session.pictures()
    said = shown_data(session, pictures, session.effects(), session.sweeps(pictures))
    assert set(json.loads(json.dumps(said, allow_nan=False))) == set(said)
    (panel,) = said["records"]
    assert panel["grade"] == "good"
    assert dict(panel["numbers"])["residual"] == f"{1e3 * pictures['full_46'].numbers.residual.residual_rms:.2f} mN m"
    still = page_data(campaign, session.state.knobs, session.scenes)
    assert {k["name"] for group in still["groups"] for k in group["knobs"]} == set(said["knobs"])
    assert all(k["meaning"] in k["hover"] for group in still["groups"] for k in group["knobs"])
