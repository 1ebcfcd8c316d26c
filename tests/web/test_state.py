"""What a tab has set. Truth: the files' values and bounds, and the laws of undoing."""

import math
import random

import pytest

import synthetic
from mechid.errors import UsageError
from mechid.parameter import Status
from mechid.web.knobs import knobs
from mechid.web.state import campaign_at, first_state


@pytest.fixture(scope="module")
def demo():
    """Return a campaign of the demo's mechanism, 15 parameters free."""
    return synthetic.bench(synthetic.truth(), synthetic.truth(), "full_46", seed=1, seconds=0.05)


def test_every_parameter_that_is_no_count_can_be_turned_between_the_bounds_of_the_file(demo):
    turned = knobs(demo)
    for name, q in demo.mechanism.parameters.items():
        assert (name in turned) == (not q.declaration.structural and not q.tied_to)
        if q.is_free:
            assert (turned[name].parameter.min, turned[name].parameter.max) == (q.min, q.max)
            assert turned[name].is_bounded
        elif name in turned:
            knob = turned[name]
            assert not knob.is_bounded
            assert q.declaration.lower <= knob.parameter.min < q.value < knob.parameter.max <= q.declaration.upper


@pytest.mark.parametrize("name", ["gear.stiffness", "friction.static", "stepper.detent.0.phase_deg"])
def test_places_run_from_end_to_end_on_the_scale_of_the_search(demo, name):
    """Truth: log of values that the search takes the log of, else proportion."""
    knob = knobs(demo)[name]
    low, high = knob.parameter.min, knob.parameter.max
    assert (knob.place(low), knob.place(high), knob.place(2 * high - low)) == (0.0, 1.0, 1.0)
    middle = math.sqrt(low * high) if name == "gear.stiffness" else 0.5 * (low + high)
    assert knob.place(middle) == pytest.approx(0.5)


def test_a_free_time_offset_of_a_record_has_a_knob():
    torque = synthetic.torque_of(synthetic.truth(), synthetic.COMMANDS["full_46"], 101)
    bounds = {"value": 0.0, "min": -0.002, "max": 0.002}
    record = synthetic.record("a", torque, synthetic.COMMANDS["full_46"], time_offset=bounds)
    campaign = synthetic.campaign(synthetic.truth(), record)
    state = first_state(campaign).set_value("record.a.time_offset_s", 0.001)
    assert campaign_at(campaign, state).record("a").time_offset.value == 0.001
    held = campaign_at(campaign, state.with_free("record.a.time_offset_s", is_free=False))
    assert held.record("a").time_offset.status is Status.KNOWN


def test_what_is_free_is_what_the_fit_may_move(demo):
    state = first_state(demo).with_free("load.inertia", is_free=True).with_free("gear.damping", is_free=False)
    free = {q.name for q in campaign_at(demo, state).mechanism.free}
    assert free == {q.name for q in demo.mechanism.free} - {"gear.damping"} | {"load.inertia"}


def test_everything_is_undone_in_order_and_a_drag_at_once(demo):
    """Truth: the settings as they were."""
    rng, state = random.Random(4), first_state(demo)
    was = [state.now]
    for k in range(20):
        name = rng.choice(sorted(state.knobs))
        if rng.random() < 0.3:
            state = state.with_free(name, is_free=name not in state.now.free)
        else:
            knob = state.knobs[name].parameter
            for _ in range(3):
                state = state.set_value(name, rng.uniform(knob.min, knob.max), grip=f"grip {k}")
        was.append(state.now)
    for setting in reversed(was[:-1]):
        state = state.undo()
        assert state.now == setting
    assert state.undo().now == was[0]


@pytest.mark.parametrize(
    ("name", "value", "static", "coulomb"),
    [("friction.coulomb", 0.05, 0.05, 0.05), ("friction.static", 0.0001, 0.0001, 0.0001)],
)
def test_static_friction_is_never_below_coulomb_friction(demo, name, value, static, coulomb):
    values = first_state(demo).set_value(name, value).now.values
    assert (values["friction.static"], values["friction.coulomb"]) == (static, coulomb)


def test_a_knob_stops_at_its_ends_and_refuses_what_is_no_number(demo):
    state = first_state(demo)
    assert state.set_value("gear.stiffness", 1e9).now.values["gear.stiffness"] == 5000.0
    for value in (math.nan, math.inf):
        with pytest.raises(UsageError, match=r"gear\.stiffness"):
            state.set_value("gear.stiffness", value)
    with pytest.raises(UsageError, match=r"did you mean .gear\.stiffness"):
        state.set_value("gear.stifness", 1000.0)
