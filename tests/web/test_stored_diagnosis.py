"""Effects that a diagnosis names, with a switch each. Truth: the simulation without them, the file as written."""

from dataclasses import replace

import numpy as np
import pytest

import synthetic
from diagnosis_folder import DETENT, detent, left, less, missing
from mechid.campaign import load_mechanism
from mechid.campaign.campaign import record_parameter_name
from mechid.errors import InputFileError, UsageError
from mechid.identification.result.diagnosis_file import FILE_NAME, PROPOSED_NAME
from mechid.plant.superset import rivals_of, superset_of
from mechid.web import Source, read_diagnosed
from mechid.web.diagnosis_content import diagnosed_data
from mechid.web.estimate import Estimate
from mechid.web.page_content import shown_data
from mechid.web.session import Session

VOLTAGE = {record_parameter_name(name, "peak_voltage"): v for name, v in (("full_46", 5.8), ("micro_46", 5.6))}


@pytest.fixture
def session(diagnosed):
    return Session(diagnosed)


def saved(session, tmp_path):
    path = tmp_path / "mechanism.toml"
    path.write_text(session.mechanism_file(), encoding="utf-8")
    return load_mechanism(path)


def test_a_switch_takes_an_effect_away_and_brings_it_back_and_undo_covers_it(session, whole):
    """Truth: the bench's own simulation with the detent, and with none of it."""
    on = session.pictures()["full_46"].modelled
    assert np.abs(on - synthetic.torque_of(whole, synthetic.COMMANDS["full_46"], 3001)).max() < 1e-4
    began = session.state.now
    session.switch("stepper.detent:3.6deg", is_on=False)
    off = session.pictures()["full_46"].modelled
    none = whole.with_values({DETENT[0]: 0.0})
    assert np.abs(off - synthetic.torque_of(none, synthetic.COMMANDS["full_46"], 3001)).max() < 1e-4
    assert np.abs(off - on).max() > 0.01
    assert shown_data(session, {}, {}, {})["effects"] == {"stepper.detent:3.6deg": False}
    assert session.state.now.free == began.free - set(DETENT)
    session.undo()
    assert session.state.now == began
    session.turn(DETENT[0], 0.03)
    session.switch("stepper.detent:3.6deg", is_on=False)
    session.switch("stepper.detent:3.6deg", is_on=True)
    assert session.state.now == began
    session.turn(DETENT[0], 0.0)
    assert shown_data(session, {}, {}, {})["effects"] == {"stepper.detent:3.6deg": False}


def test_the_saved_file_has_what_is_on_only(session, whole, tmp_path):
    assert saved(session, tmp_path).parameters.keys() == whole.parameters.keys()
    session.turn("gear.stiffness", 900.0)
    session.switch("stepper.detent:3.6deg", is_on=False)
    written = less(whole, "stepper.detent").with_values({"gear.stiffness": 900.0})
    read = saved(session, tmp_path)
    assert {n: read.value(n) for n in read.parameters} == {n: written.value(n) for n in written.parameters}
    assert [q.name for q in read.free] == ["gear.stiffness"]


def test_the_page_says_what_each_is_and_what_was_tried(session):
    data = diagnosed_data(session.source.diagnosed)
    (entry,) = data["effects"]
    assert entry["explains"] == "Explains 90 % of the misfit"
    assert entry["aliases"] == [
        "the two phases differ in torque constant, resistance or inductance (stepper.imbalance)"
    ]
    assert entry["sliders"] == [("stepper.detent.1", DETENT[0])]
    assert data["tried"][0]["words"] == "Backlash of the gear"
    assert shown_data(session, {}, {}, {})["primary"] == "fit"
    with pytest.raises(UsageError, match="no effect"):
        session.switch("gear.backlash", is_on=True)


def test_the_estimate_has_none_of_it_and_the_file_all(session, campaign, whole):
    values = {name: q.value for name, q in campaign.parameters.items() if name not in DETENT}
    estimate = Estimate(source="a fit", values=values, sigmas={}, summary={}, records=campaign.records)
    tab = Session(replace(session.source, estimate=estimate))
    assert tab.state.now == session.state.now
    tab.to_estimate()
    assert tab.state.now.values[DETENT[0]] == 0.0
    assert not set(DETENT) & tab.state.now.free
    assert tab.state.now.values["gear.stiffness"] == values["gear.stiffness"]
    tab.to_file()
    assert tab.state.now == session.state.now


def test_of_two_entries_of_a_list_the_second_moves_up_where_the_first_is_off(campaign, tmp_path):
    """Truth: the superset of the mechanism as written, laid out with the second alone."""
    base = synthetic.truth()
    names = ("stepper.detent:7.2deg", "stepper.detent:0.9deg", "friction.directional")
    superset = superset_of(base, only=names)
    found = {name: 0.25 * width for name, width in superset.widths.items()}
    proposed = superset.with_free_terms(names).with_values(found)
    effects = [
        missing(name, {n: proposed.value(n) for n, t in superset.term_of.items() if t == name}, name.partition(":")[0])
        for name in names
    ]
    changed, said = read_diagnosed(left(tmp_path, proposed, *effects), replace(campaign, mechanism=base), None)
    session = Session(Source(changed, diagnosed=said))
    for name in (names[0], names[2]):
        session.switch(name, is_on=False)
    alone = superset_of(base, only=(names[1],)).mechanism
    read = saved(session, tmp_path)
    assert read.parameters.keys() == alone.parameters.keys()
    assert "friction.law" not in read.options
    assert read.value("stepper.detent.2.period_deg") == pytest.approx(0.9)
    assert read.value("stepper.detent.2.amplitude") == proposed.value("stepper.detent.3.amplitude")
    session.switch(names[2], is_on=True)
    assert saved(session, tmp_path).value("friction.asymmetry") == found["friction.asymmetry"]


@pytest.mark.parametrize(
    ("name", "key", "has_switch"),
    [("friction.load_dependent", "load_share", True), ("gear.backlash", "backlash", False)],
)
def test_a_law_in_place_of_another_has_a_switch_where_it_has_a_null(campaign, tmp_path, name, key, has_switch):
    base = synthetic.truth()
    law = next(law for law in rivals_of(base) if law.name == name)
    own = f"{law.own[0].rpartition('.')[0]}.{key}"
    effect = missing(name, {own: law.mechanism.value(own)}, own.partition(".")[0])
    changed, said = read_diagnosed(left(tmp_path, law.mechanism, effect), replace(campaign, mechanism=base), None)
    session = Session(Source(changed, diagnosed=said))
    (entry,) = diagnosed_data(said)["effects"]
    assert entry["fixed"] != has_switch
    assert own in session.state.knobs
    if has_switch:
        session.switch(name, is_on=False)
        assert session.state.now.values[own] == 0.0
        assert saved(session, tmp_path).options == base.options
    else:
        assert "without --diagnosis" in entry["why_fixed"]
        with pytest.raises(UsageError, match="no effect"):
            session.switch(name, is_on=False)


def test_values_of_records_have_a_switch_and_follow_the_mechanism_where_it_is_off(campaign, whole, tmp_path):
    """Truth: the simulation at the voltage of the record, and at that of the mechanism as it is turned."""
    effect = missing("record.voltage", VOLTAGE, "")
    folder = left(tmp_path, whole, effect)
    changed, said = read_diagnosed(folder, replace(campaign, mechanism=whole), None)
    session = Session(Source(changed, diagnosed=said))

    def off_by(volts):
        truth = synthetic.torque_of(
            whole.with_values({"stepper.peak_voltage": volts}), synthetic.COMMANDS["full_46"], 3001
        )
        return np.abs(session.pictures()["full_46"].modelled - truth).max()

    assert off_by(VOLTAGE["record.full_46.peak_voltage"]) < 1e-4
    session.switch("record.voltage", is_on=False)
    assert off_by(whole.value("stepper.peak_voltage")) < 1e-4
    session.turn("stepper.peak_voltage", 9.0)
    assert off_by(9.0) < 1e-4
    assert shown_data(session, {}, {}, {})["effects"] == {"record.voltage": False}
    assert not any(q.replaces for r in session._remove_disabled(session.campaign).records for q in r.parameters)
    session.undo()
    session.undo()
    assert off_by(VOLTAGE["record.full_46.peak_voltage"]) < 1e-4
    assert saved(session, tmp_path).parameters.keys() == whole.parameters.keys()


def test_a_fit_leaves_what_is_off_as_it_is(campaign, whole, tmp_path):
    """Truth: the stiffness behind the records, which were made at the mechanism's own voltage."""
    base = whole.with_free(("gear.stiffness",))
    changed, said = read_diagnosed(
        left(tmp_path, base, missing("record.voltage", VOLTAGE, "")), replace(campaign, mechanism=base), None
    )
    session = Session(Source(changed, workers=1, diagnosed=said))
    session.switch("record.voltage", is_on=False)
    session.turn("gear.stiffness", 1.02 * whole.value("gear.stiffness"))
    session.fit_from_here()
    assert session.run.wait(60.0)
    assert session.adopt_result(), session.run.fault
    assert abs(session.estimate.sigmas_from("gear.stiffness", whole.value("gear.stiffness"))) < 4.0
    assert not VOLTAGE.keys() & session.estimate.values.keys()
    assert shown_data(session, {}, {}, {})["effects"] == {"record.voltage": False}
    session.switch("record.voltage", is_on=True)
    assert session.pictures()["full_46"].numbers.residual.ratio > 1.5


def test_what_has_no_value_to_set_as_hum_has_no_switch_and_the_page_says_why(campaign, whole, tmp_path):
    effect = missing("mains:50Hz", {"campaign.mains_hz": 50.0}, "")
    changed, said = read_diagnosed(left(tmp_path, whole, effect), replace(campaign, mechanism=whole), None)
    (entry,) = diagnosed_data(said)["effects"]
    assert entry["fixed"]
    assert "no such value to set" in entry["hover"]
    assert Session(Source(changed, diagnosed=said)).state.knobs.keys().isdisjoint(effect.parameters)


def test_where_nothing_is_named_the_page_is_as_without_and_has_the_sentence(campaign, tmp_path):
    changed, said = read_diagnosed(left(tmp_path, None), campaign, None)
    assert (changed.mechanism, changed.mechanism_path) == (campaign.mechanism, campaign.mechanism_path)
    data = diagnosed_data(said)
    assert (data["words"], data["effects"], len(data["tried"])) == ("What is said of the whole.", [], 1)


def test_a_diagnosis_of_another_campaign_is_refused(campaign, whole, tmp_path):
    written = replace(campaign, mechanism=less(whole, "stepper.detent"))
    left(tmp_path, whole.with_values({"gear.ratio": 51.0}), detent(whole))
    with pytest.raises(InputFileError, match=r"gear\.ratio is 51 there and 50 here; diagnose anew"):
        read_diagnosed(tmp_path, written, None)
    left(tmp_path, less(whole, "housing"), detent(whole))
    with pytest.raises(InputFileError, match=r"it lacks housing"):
        read_diagnosed(tmp_path, written, None)
    law = next(law for law in rivals_of(whole) if law.name == "gear.backlash")
    left(tmp_path, law.mechanism, detent(whole))
    with pytest.raises(InputFileError, match=r"gear\.backlash is in one of them only"):
        read_diagnosed(tmp_path, written, None)
    left(tmp_path, whole, replace(detent(whole), records=("other",)))
    with pytest.raises(InputFileError, match='names the record "other"'):
        read_diagnosed(tmp_path, written, None)


@pytest.mark.parametrize(
    ("changes", "said"),
    [({"format": "mechid-look/1"}, "format"), ({"missing": [{}]}, "damaged"), ({"tried": 3}, "damaged")],
)
def test_a_damaged_diagnosis_is_refused(campaign, whole, tmp_path, changes, said):
    with pytest.raises(InputFileError, match=rf"{FILE_NAME}: .*{said}.*diagnose anew"):
        read_diagnosed(left(tmp_path, whole, **changes), campaign, None)


def test_a_file_that_is_not_there_is_said(campaign, whole, tmp_path):
    with pytest.raises(InputFileError, match=f"{FILE_NAME}: there is no such file"):
        read_diagnosed(tmp_path, campaign, None)
    with pytest.raises(InputFileError, match=f"{PROPOSED_NAME}: there is no such file"):
        read_diagnosed(left(tmp_path, None, detent(whole)), campaign, None)
    (tmp_path / FILE_NAME).write_text("{", encoding="utf-8")
    with pytest.raises(InputFileError, match="cannot be read"):
        read_diagnosed(tmp_path, campaign, None)
