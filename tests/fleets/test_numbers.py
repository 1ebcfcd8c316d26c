"""Every number of a fleet. Truth: the files by hand."""

import json

import mechid
from estimates import free
from mechid.fleets.numbers import fleet_data
from mechid.identification.result.estimate_file import json_text
from synthetic_fleet import write_fit


def made(tmp_path, *sources):
    return mechid.fleet(*sources, out=tmp_path / "out")


def parameter(fleet, name):
    return next(p for p in fleet.parameters if p.name == name)


def test_one_unit_alone_and_no_unit_at_all(tmp_path):
    one = made(tmp_path, write_fit(tmp_path / "a", {"gear.stiffness": free(900.0, 1.0)}))
    assert parameter(one, "gear.stiffness").spread is None
    broken = tmp_path / "b"
    broken.mkdir()
    (broken / "estimate.json").write_text("{", encoding="utf-8")
    none = made(tmp_path, broken)
    assert (none.failed, none.parameters) == (("b",), ())
    assert "is damaged" in none.runs[0].said
    for fleet in (one, none):
        assert json.loads(json_text(fleet_data(fleet, tmp_path)))["format"] == "mechid-fleet/1"


def test_the_numbers_are_those_of_the_files(tmp_path):
    """Truth: the values written, a mean that lies between them, and paths from where fleet.json lies."""
    values = {"a": (900.0, 1.0), "b": (910.0, 2.0), "c": (905.0, 1.0)}
    folders = [write_fit(tmp_path / n, {"gear.stiffness": free(*values[n])}) for n in values]
    data = json.loads(json_text(fleet_data(made(tmp_path, *folders), tmp_path)))
    assert [campaign["label"] for campaign in data["campaigns"]] == list(values)
    (entry,) = [p for p in data["parameters"] if p["name"] == "gear.stiffness"]
    found = [(value["value"], value["std_error"]) for value in entry["values"]]
    assert found == list(values.values())
    assert 900.0 < entry["mean"] < 910.0
    assert entry["mean95"][0] < entry["mean"] < entry["mean95"][1]
    assert [(c["folder"], c["how"], c["report"]) for c in data["campaigns"]] == [(n, "given", False) for n in values]
