"""Tabs of the explorer as documents without a browser. Truth: who holds a session, and who is held by nobody."""

import gc
import json
import math
import weakref

import pytest
from bokeh.document import Document

from diagnosis_folder import DETENT
from mechid.plant.mechanism import NamedLine
from mechid.web.equations import Equations
from mechid.web.tab import Tab

KNOB = "gear.stiffness"


@pytest.fixture
def tabs():
    return {}


@pytest.fixture
def open_tab(source, tabs, monkeypatch):
    """Return what opens a tab; those in `closed` have no page."""
    closed = set()
    monkeypatch.setattr(Tab, "is_closed", property(lambda tab: tab.token in closed))

    def opened():
        return Tab(source, Equations(source.campaign.mechanism.plant), Document(), tabs)

    opened.closed = closed
    return opened


def asked(page, **message):
    page.wire.asked = json.dumps(message)
    return json.loads(page.wire.page_state)


def forgotten(tab):
    """Do what Bokeh does with the document of a page that is gone."""
    for callback in tab.document.callbacks.session_destroyed_callbacks:
        callback(None)


def test_a_page_takes_over_the_session_of_the_closed_one_whose_token_it_has(open_tab, tabs):
    earlier = open_tab()
    asked(earlier, do="turn", name=KNOB, value=700.0, number=1)
    session, now = earlier.session, open_tab()
    open_tab.closed.add(earlier.token)
    state = asked(now, do="hello", tab=earlier.token, number=1)
    assert now.session is session
    assert state["knobs"][KNOB]["value"] == 700.0
    assert state["can_undo"]
    assert list(tabs.values()) == [now]
    forgotten(earlier)
    assert list(tabs.values()) == [now]


@pytest.mark.parametrize("token", ["", "guessed", None])
def test_a_token_that_no_page_had_takes_nothing(open_tab, token):
    earlier, now = open_tab(), open_tab()
    asked(earlier, do="turn", name=KNOB, value=700.0, number=1)
    open_tab.closed.add(earlier.token)
    assert asked(now, do="hello", tab=token, number=1)["knobs"][KNOB]["value"] != 700.0
    assert earlier.session is not now.session


def test_a_page_that_is_open_keeps_its_session_until_it_closes(open_tab):
    """The page that waits takes it then, unless something was done on it."""
    earlier, now = open_tab(), open_tab()
    session = earlier.session
    asked(now, do="hello", tab=earlier.token, number=1)
    assert now.session is not session
    open_tab.closed.add(earlier.token)
    now._poll()
    assert now.session is session
    third = open_tab()
    asked(third, do="hello", tab=now.token, number=1)
    asked(third, do="free", name=KNOB, number=2, **{"is": False})
    open_tab.closed.add(now.token)
    third._poll()
    assert third.session is not session


def test_a_tab_that_is_forgotten_is_held_by_nothing(open_tab, tabs):
    tab = open_tab()
    held = weakref.ref(tab)
    forgotten(tab)
    assert tabs == {}
    tab.document.clear()
    del tab
    gc.collect()
    assert held() is None


def test_a_value_that_another_parameter_limits_is_said(open_tab):
    """Truth: the plant's rule, static friction is not below Coulomb friction, and the upper end of both."""
    tab = open_tab()
    session = tab.session
    coulomb, static = (session.state.knobs[f"friction.{name}"].parameter for name in ("coulomb", "static"))
    asked_for = 2.0 * max(coulomb.max, static.max)
    state = asked(tab, do="turn", name="friction.coulomb", value=asked_for, number=1)
    used = state["knobs"]["friction.coulomb"]["value"]
    assert used <= min(coulomb.max, static.max)
    assert "is used" in state["limited"]["friction.coulomb"]
    assert asked(tab, do="turn", name="friction.coulomb", value=used, number=2)["limited"] == {}


def test_a_page_gets_rows_for_the_terms_that_a_fit_added(lacking, open_tab, tabs):
    """Truth: the parameters of the mechanism with the terms; the equations of the term in hand are its own."""
    source, estimate = lacking
    page = Tab(source, Equations(source.campaign.mechanism.plant), Document(), tabs)
    assert "groups" not in asked(page, do="take", name=KNOB, number=1)
    page.session._adopt_estimate(estimate)
    state = asked(page, do="take", name=DETENT[0], number=2)
    assert all(f'data-name="{name}"' in state["groups"] for name in state["knobs"])
    assert set(DETENT) <= state["knobs"].keys()
    assert state["equations"]
    assert "groups" not in asked(page, do="take", name=KNOB, number=3)
    later = Tab(source, Equations(source.campaign.mechanism.plant), Document(), tabs)
    open_tab.closed.add(page.token)
    assert "groups" in asked(later, do="hello", tab=page.token, number=1)
    assert "groups" not in asked(later, do="take", name=KNOB, number=2)


def test_the_key_of_a_picture_has_the_lines_that_the_mechanism_names(open_tab, source, monkeypatch):
    assert open_tab().document.template_variables["marked"] == "orders of the step rate"
    lines = (NamedLine("mesh 1", "of a mesh", 8.0, 0.16), NamedLine("chopper", "its clock", math.nan, None, 2e4))
    monkeypatch.setitem(vars(source.campaign.mechanism), "named_lines", lines)
    assert open_tab().document.template_variables["marked"] == "orders of the step rate, mesh 1, chopper"
