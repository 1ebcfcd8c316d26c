"""A mechanism as text. Truth: the mechanism itself, which is read back to the last digit."""

import math
from dataclasses import replace

import numpy as np
import pytest

from mechid.campaign import catalogue_mechanism, load_mechanism, mechanism_text, write_mechanism
from mechid.campaign.toml_file import read_toml, toml_text
from mechid.errors import UnwritableError
from mechid.parameter import Status

TEXTS = ["plain", 'with "quotes"', "C:\\data\\run", "tab\tand\nline", "Prüf 90°", "\x7f"]
AWKWARD = [0.1 + 0.2, 1e-300, 5e-324, math.pi * 1e-6, 123456789.123456789]


def same(one, other):
    assert one.options == other.options
    assert one.plant == other.plant
    assert dict(one.parameters) == dict(other.parameters)


@pytest.mark.parametrize("name", ["exact", "noisy"])
def test_the_independent_campaigns_mechanisms_survive(name, campaign_folder, tmp_path):
    mechanism = load_mechanism(campaign_folder / name / "mechanism.toml")
    write_mechanism(mechanism, tmp_path / "mechanism.toml", "read and written")
    same(load_mechanism(tmp_path / "mechanism.toml"), mechanism)


def test_every_kind_of_entry_survives(folder):
    mechanism = load_mechanism(folder / "mechanism.toml")
    write_mechanism(mechanism, folder / "again.toml")
    same(load_mechanism(folder / "again.toml"), mechanism)


def test_a_rigid_housing_survives(folder):
    mechanism = load_mechanism(folder / "mechanism.toml")
    content = (folder / "mechanism.toml").read_text()
    (folder / "rigid.toml").write_text(content[: content.index("[housing]")])
    mechanism = load_mechanism(folder / "rigid.toml")
    write_mechanism(mechanism, folder / "again.toml")
    same(load_mechanism(folder / "again.toml"), mechanism)


@pytest.mark.parametrize("value", AWKWARD)
def test_values_survive_to_the_last_digit(value, tmp_path):
    """Truth: the shortest decimal that reads back to the same number; NumPy's too."""
    mechanism = catalogue_mechanism().with_values({"load.inertia": np.float64(value)})
    write_mechanism(mechanism, tmp_path / "mechanism.toml")
    assert load_mechanism(tmp_path / "mechanism.toml").value("load.inertia") == value


def test_what_the_fit_froze_is_free_again(tmp_path):
    """Truth: docs/files.md: mechanism.toml with the estimated values; the next fit starts from it."""
    mechanism = catalogue_mechanism()
    stuck = {
        "gear.damping": replace(mechanism.parameters["gear.damping"], status=Status.FROZEN),
        "gear.stiffness": replace(mechanism.parameters["gear.stiffness"], status=Status.AT_BOUND),
    }
    write_mechanism(mechanism.with_parameters(stuck), tmp_path / "mechanism.toml")
    assert load_mechanism(tmp_path / "mechanism.toml").free == mechanism.free


def test_each_line_says_symbol_unit_and_meaning():
    """Truth: the declarations of the blocks."""
    mechanism = catalogue_mechanism()
    written = mechanism_text(mechanism, "first\n\nthird").splitlines()
    assert written[:4] == ["# first", "#", "# third", ""]
    for declaration in mechanism.plant.declarations.values():
        unit = "" if declaration.unit == "1" else f", {declaration.unit}"
        assert any(f"# {declaration.symbol}{unit}: {declaration.meaning}" in line for line in written)


def test_an_earlier_file_is_replaced_and_nothing_left_beside(folder):
    write_mechanism(catalogue_mechanism(), folder / "mechanism.toml")
    assert load_mechanism(folder / "mechanism.toml").value("gear.ratio") == 50.0
    assert sorted(path.name for path in folder.iterdir()) == [
        "campaign.toml",
        "full_46.csv",
        "mechanism.toml",
        "sweep.csv",
    ]


def test_a_file_that_cannot_be_written_stays_as_it_was(folder, monkeypatch):
    path = folder / "mechanism.toml"
    before = path.read_text()
    monkeypatch.setattr("pathlib.Path.replace", lambda *_: (_ for _ in ()).throw(OSError(28, "disk full")))
    with pytest.raises(UnwritableError, match="disk"):
        write_mechanism(catalogue_mechanism(), path)
    assert path.read_text() == before
    assert not list(folder.glob(".*"))


@pytest.mark.parametrize("text", TEXTS)
def test_any_text_survives(text, tmp_path):
    (tmp_path / "x.toml").write_text(f"x = {toml_text(text)}\n", encoding="utf-8")
    assert read_toml(tmp_path / "x.toml") == {"x": text}
