"""The texts of a fleet's numbers. Truth: the values that the fits were written with."""

from mechid.fleets.texts import fleet_texts


def test_terms_that_only_some_have_are_said_to_have_no_mean(data):
    row = next(p for p in fleet_texts(data)["parameters"] if p["name"] == "stepper.detent.0.amplitude")
    assert (row["text"]["mean"], row["text"]["lacking"]) == ("–", "14 of 16 have no such")
    cells = [row["by_unit"]["text"][f"cell_{k}"] for k in range(3)]
    assert cells == ["0.001000 ± 0.000010", "0.001000 ± 0.000010", ""]


def test_a_change_has_its_error_and_is_told_in_its_errors(data):
    """Truth: a tenth more damping in each unit, of some 0.39 N m s/rad."""
    change = next(c for c in fleet_texts(data)["mean_changes"] if c["name"] == "gear.damping")
    assert change["text"]["mean"].startswith("0.039")
    assert " ± 0.00" in change["text"]["mean"]
    own = next(c for c in fleet_texts(data)["changes"] if c["name"] == "gear.damping" and c["unit"] == "FM5")
    assert own["text"]["sigmas"] == f"{own['difference'] / own['error']:+.1f}"
