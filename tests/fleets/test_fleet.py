"""A fleet of finished fits. Truth: synthetic fleets of known mean, spread, trend, changes and outliers."""

import numpy as np

import mechid
from estimates import free, known
from mechid.fleets.cautions import cautions
from synthetic_fleet import MEANS, NAMES, Truth, drawn, quoted, write_fit, write_fleet_file


def made(tmp_path, *sources):
    return mechid.fleet(*sources, out=tmp_path / "out")


def parameter(fleet, name):
    return next(p for p in fleet.parameters if p.name == name)


def test_mean_and_spread_of_a_known_fleet(tmp_path):
    """20 units, spread 2 % and errors 0.25 to 1 % of the mean; five parameters, so that one interval may miss."""
    fleet = made(tmp_path, *drawn(tmp_path, 20, seed=2))
    inside = 0
    for name in NAMES:
        p = parameter(fleet, name)
        low, high = p.spread.spread95
        inside += low < 0.02 * MEANS[name] < high
        assert abs(p.spread.mean - MEANS[name]) < 4.0 * p.spread.error
        assert p.differs
        assert not p.outliers
    assert inside >= 4
    assert not fleet.failed


def test_units_that_are_alike_do_not_differ(tmp_path):
    fleet = made(tmp_path, *drawn(tmp_path, 12, seed=3, truth=Truth(spread=0.0)))
    assert not any(p.differs for p in fleet.parameters)


def test_a_trend_is_found_and_taken_out_before_units_are_compared(tmp_path):
    truth, rng = Truth(slopes={"friction.viscous": -0.004}), np.random.default_rng(4)
    temperatures = np.linspace(-20.0, 50.0, 12)
    entries = []
    for k, kelvin in enumerate(temperatures):
        write_fit(tmp_path / f"FM{k}", truth.estimated(truth.unit(rng), rng, kelvin))
        entries.append({"folder": f'"FM{k}"', "covariates": f"{{ temperature_degC = {kelvin:.6g} }}"})
    fleet = made(tmp_path, write_fleet_file(tmp_path, entries))
    (found,) = [t.result for t in fleet.trends if t.found]
    slope = -0.004 * MEANS["friction.viscous"]
    assert found.name == "friction.viscous"
    assert found.slope95[0] < slope < found.slope95[1]
    p = parameter(fleet, "friction.viscous")
    assert p.along is found
    low, high = p.spread.spread95
    assert low < 0.02 * MEANS["friction.viscous"] < high


def test_changes_are_found_in_the_unit_and_in_the_parameter_that_changed(tmp_path):
    truth, rng, entries = Truth(), np.random.default_rng(5), []
    for k in range(6):
        unit = truth.unit(rng)
        for state in ("before", "after"):
            if state == "after" and k == 2:
                unit = unit | {"gear.damping": 1.15 * unit["gear.damping"]}
            if state == "after":
                unit = unit | {"friction.viscous": 1.05 * unit["friction.viscous"]}
            write_fit(tmp_path / f"{k}{state}", truth.estimated(unit, rng))
            entries.append({"folder": quoted(f"{k}{state}"), "unit": quoted(f"FM{k}"), "state": quoted(state)})
    fleet = made(tmp_path, write_fleet_file(tmp_path, entries, 'before_after = [["before", "after"]]'))
    assert [c.result.name for c in fleet.mean_changes if c.found] == ["friction.viscous"]
    changed = {(c.result.unit, c.result.name) for c in fleet.changes if c.found}
    assert ("FM2", "gear.damping") in changed
    assert {name for _, name in changed} == {"gear.damping", "friction.viscous"}
    assert parameter(fleet, "gear.damping").spread.unit_values.units == tuple(f"FM{k}" for k in range(6))
    assert np.isnan(parameter(fleet, "gear.damping").spread.unit_values.repeatability)


def test_units_of_another_lot_are_told_apart(tmp_path):
    truth, rng, entries = Truth(), np.random.default_rng(6), []
    for k in range(12):
        lot = "A" if k < 6 else "B"
        unit = truth.unit(rng)
        unit["gear.stiffness"] *= 1.0 if lot == "A" else 1.15
        write_fit(tmp_path / f"FM{k}", truth.estimated(unit, rng))
        entries.append({"folder": f'"FM{k}"', "group": quoted(lot)})
    fleet = made(tmp_path, write_fleet_file(tmp_path, entries))
    assert [g.result.name for g in fleet.groups if g.found] == ["gear.stiffness"]


def test_covariates_that_go_together_and_known_values_that_differ_are_said(tmp_path):
    entries = []
    for k in range(4):
        write_fit(
            tmp_path / f"FM{k}", {"gear.stiffness": free(900.0 + k, 1.0), "load.inertia": known(0.01 + 0.01 * (k == 3))}
        )
        entries.append(
            {"folder": f'"FM{k}"', "covariates": f"{{ cycles = {1000 * k}, date = 2026-01-{1 + 3 * k:02d} }}"}
        )
    said = " ".join(cautions(made(tmp_path, write_fleet_file(tmp_path, entries))))
    assert "cycles and date go together over the campaigns (correlation 1.00)" in said
    assert "load.inertia is a known number in the mechanism files, and not the same in all" in said
