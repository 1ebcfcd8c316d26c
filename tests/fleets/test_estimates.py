"""Which estimates count in a fleet. Truth: the files by hand."""

import pytest

import mechid
from estimates import free, known
from mechid.fleets.cautions import cautions
from mechid.fleets.numbers import fleet_data
from synthetic_fleet import write_fit


def made(tmp_path, *sources):
    return mechid.fleet(*sources, out=tmp_path / "out")


def parameter(fleet, name):
    return next(p for p in fleet.parameters if p.name == name)


def test_entries_of_a_list_are_matched_by_period_and_terms_of_some_have_no_mean(tmp_path):
    """The 3.6 deg detent stands first in one file and second in the others; only one has a 0.9 deg one."""

    def detents(**amplitudes):
        out = {}
        for k, (period, value) in enumerate(amplitudes.items()):
            degrees = float(period.lstrip("p").replace("_", "."))
            out[f"stepper.detent.{k}.period_deg"] = known(degrees, "deg")
            out[f"stepper.detent.{k}.amplitude"] = free(value, 1e-5, "N m")
        return out

    folders = [
        write_fit(tmp_path / "a", detents(p1_8=0.0047, p3_6=0.023)),
        write_fit(tmp_path / "b", detents(p3_6=0.024, p1_8=0.0048)),
        write_fit(tmp_path / "c", detents(p1_8=0.0046, p3_6=0.022, p0_9=0.001), plant="another"),
    ]
    fleet = made(tmp_path, *folders)
    assert parameter(fleet, "stepper.detent.3.6deg.amplitude").spread.mean == pytest.approx(0.023, rel=1e-6)
    lone = parameter(fleet, "stepper.detent.0.9deg.amplitude")
    assert (lone.lacking, lone.spread) == (("a", "b"), None)
    row = next(p for p in fleet_data(fleet, tmp_path)["parameters"] if p["name"] == lone.name)
    assert (row["mean"], [v and v["value"] for v in row["values"]]) == (None, [None, None, 0.001])
    assert any("2 sets of equations, as those of a, c" in line for line in cautions(fleet))


def test_what_does_not_count_is_shown_with_its_reason(tmp_path):
    values = {"gear.stiffness": free(900.0, 1.0), "gear.damping": free(0.4, 0.01)}
    held = {"gear.stiffness": free(905.0, 1.0), "gear.damping": {**free(0.4, None), "status": "frozen"}}
    near = {name: {**p, "local_only": True} for name, p in values.items()}
    few = {**values, "gear.stiffness": {**free(902.0, 1.0), "dof": 4.0}}
    fits = (("a", values, "A"), ("b", held, "B"), ("c", values, "C"), ("d", near, "B"), ("e", few, "A"))
    folders = [write_fit(tmp_path / name, p, grade=grade) for name, p, grade in fits]
    fleet = made(tmp_path, *folders)
    rows = {p["name"]: p for p in fleet_data(fleet, tmp_path)["parameters"]}
    assert [v["left_out"] for v in rows["gear.damping"]["values"]] == ["", "frozen", "grade C", "", ""]
    assert [v["near_threshold"] for v in rows["gear.damping"]["values"]] == [False, False, False, True, False]
    assert fleet.failed == ("c",)
    said = " ".join(cautions(fleet))
    assert "gear.damping was held (frozen) in b" in said
    assert "Near a stick/slip threshold, so that standard errors hold on one side of it only: d." in said
    assert "4 units: the spread is hardly known" in said
    assert parameter(fleet, "gear.stiffness").observed.errors[-1] == pytest.approx(2.776445 / 1.959964, rel=1e-5)
