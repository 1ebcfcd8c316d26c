"""A mechanism file that is wrong. Truth: the place, what was put there, and what to write instead."""

import re

import pytest

from mechid.campaign import load_mechanism, mechanism_from_table
from mechid.errors import InputFileError

REMEDY = "write { value = ..., min = ..., max = ... }"

REFUSED = {  # what is replaced, by what -> the message behind "mechanism.toml: "
    "misspelt key": ("stiffness =", "stifness =", 'gear.stifness: unknown key; did you mean "stiffness"?'),
    "key of another table": (
        "ratio = -50",
        "ratio = -50\nviscous = 1.0",
        'gear.viscous: unknown key; did you mean "friction.viscous"?',
    ),
    "key without table": (
        "[stepper]",
        "torque_constant = 0.3\n[stepper]",
        'torque_constant: unknown key; did you mean "stepper.torque_constant"?',
    ),
    "strange key": (
        "inertia = 0.010534",
        "inertia = 0.010534\ncolour = 1",
        "load.colour: unknown key; the keys here are inertia",
    ),
    "five phases": ("[stepper]", "[stepper]\nphases = 5", "stepper.phases: found 5; write 2, 3, 4"),
    "phases in words": ("[stepper]", '[stepper]\nphases = "three"', 'stepper.phases: found "three"; write 2, 3, 4'),
    "connection of other phases": (
        "[stepper]",
        '[stepper]\nphases = 3\nconnection = "unipolar"',
        'stepper.connection: "unipolar" is of 4 phases, the motor has 3; write "star", or phases = 4',
    ),
    "unknown connection": (
        "[stepper]",
        '[stepper]\nphases = 3\nconnection = "delta"',
        'stepper.connection: found "delta"; write one of "bipolar", "star", "unipolar"',
    ),
    "misspelt table": ("[gear]", "[gears]", 'gears: unknown table; did you mean "gear"?'),
    "empty unknown table": ("[gear]", "[brake]\n[gear]", "brake: unknown table; the keys here are "),
    "misspelt detent": (
        "[[stepper.detent]]",
        "[[stepper.detents]]",
        'stepper.detents: unknown key; did you mean "detent"?',
    ),
    "unknown key of a detent": (
        "period_deg",
        "priod_deg",
        'stepper.detent.0.priod_deg: unknown key; did you mean "period_deg"?',
    ),
    "unknown key of a parameter": (
        "min = 300.0",
        "mim = 300.0",
        'gear.stiffness.mim: unknown key; did you mean "min"?',
    ),
    "missing key": (
        "damping = 0.48",
        "",
        "gear.damping: missing; write damping under [gear], gear damping at output in N m s/rad",
    ),
    "missing table": (
        "[load]\ninertia = 0.010534",
        "",
        "load.inertia: missing; write inertia under [load], test mass inertia in kg m2",
    ),
    "missing key of a detent": (
        "period_deg = 1.8",
        "",
        "stepper.detent.0.period_deg: missing; write period_deg under [[stepper.detent]], detent period",
    ),
    "missing key without unit": (
        "ratio = -50",
        "",
        "gear.ratio: missing; write ratio under [gear], transmission ratio",
    ),
    "detent in single brackets": (
        "[[stepper.detent]]",
        "[stepper.detent]",
        "stepper.detent: found a table; write each harmonic as a table under [[stepper.detent]]",
    ),
    "table in double brackets": ("[load]", "[[load]]", "load: found tables; write a table, [load]"),
    "value in a unit": (
        "coil_inductance = 0.0229",
        'coil_inductance = "22.9 mH"',
        'stepper.coil_inductance: found "22.9 mH"; write the number alone in H, without quotes',
    ),
    "text for a number without unit": (
        "ratio = -50",
        'ratio = "1:50"',
        'gear.ratio: found "1:50"; write the number alone, without quotes',
    ),
    "boolean": (
        "viscous = 9.74e-4",
        "viscous = true",
        "friction.viscous: found true; write a finite number in N m s/rad",
    ),
    "list": (
        "viscous = 9.74e-4",
        "viscous = [1.0]",
        "friction.viscous: found [1.0]; write a finite number in N m s/rad",
    ),
    "not a number": (
        "viscous = 9.74e-4",
        "viscous = nan",
        "friction.viscous: found nan; write a finite number in N m s/rad",
    ),
    "infinite bound": ("max = 5000.0", "max = inf", "gear.stiffness.max: found inf; write a finite number in N m/rad"),
    "value missing": ("value = 2200.0, ", "", f"gear.stiffness.value: missing; {REMEDY}"),
    "bound without physical limit missing": (
        ", max = 5000.0",
        "",
        f"gear.stiffness.max: missing, and gear stiffness at output has no physical limit there; {REMEDY}",
    ),
    "min above max": (
        "min = 300.0, max = 5000.0",
        "min = 5000.0, max = 300.0",
        "gear.stiffness: min = 5000 is above max = 300; exchange them",
    ),
    "min equal to max": (
        "min = 300.0, max = 5000.0",
        "min = 2200.0, max = 2200.0",
        "gear.stiffness: min and max are both 2200; write the number alone where it is known",
    ),
    "above its bounds": (
        "value = 2200.0",
        "value = 9000.0",
        "gear.stiffness: value = 9000 is above max = 5000; start within the bounds or move them",
    ),
    "below its bounds": (
        "value = 2200.0",
        "value = 200.0",
        "gear.stiffness: value = 200 is below min = 300; start within the bounds or move them",
    ),
    "hertz": (
        "value = 5000.0",
        "value = 888.0",
        "housing.frequency: value = 888 is below min = 2500; start within the bounds or move them; "
        "is it in Hz? it is read in rad/s, write 5579.47",
    ),
    "against physics": (
        "viscous = 9.74e-4",
        "viscous = -1.0",
        "friction.viscous: found -1; viscous friction cannot be below 0 N m s/rad",
    ),
    "bound against physics": (
        "min = 300.0",
        "min = -300.0",
        "gear.stiffness.min: found -300; gear stiffness at output cannot be below 0 N m/rad",
    ),
    "zero in a denominator": (
        "coil_inductance = 0.0229",
        "coil_inductance = 0",
        "stepper.coil_inductance: found 0; the equations divide by it, write another number",
    ),
    "a count to be estimated": (
        "ratio = -50",
        "ratio = { value = 50.0, min = -100.0, max = 100.0 }",
        "gear.ratio: found a table; it fixes the equations and cannot be estimated: write the number alone",
    ),
    "sigma": (
        "sigma = 0.01",
        "sigma = 0.0",
        "friction.coulomb.sigma: found 0; write the prior's standard deviation, above 0, or leave it out",
    ),
    "poles to be estimated": (
        "poles = 100",
        "poles = { value = 100, min = 50, max = 200 }",
        "stepper.poles: found a table; it fixes the equations and cannot be estimated: write the number alone",
    ),
    "period to be estimated": (
        "period_deg = 1.8",
        "period_deg = { value = 1.8, min = 1.0, max = 2.0 }",
        "stepper.detent.0.period_deg: found a table; it fixes the equations and cannot be estimated: "
        "write the number alone in deg",
    ),
    "odd poles": (
        "poles = 100",
        "poles = 99",
        "stepper.poles: found 99; poles come in pairs, write an even whole number",
    ),
    "static below Coulomb": (
        "static = 0.03",
        "static = 0.01",
        "friction.static: 0.01 is below friction.coulomb = 0.0265; static friction is never below "
        "Coulomb friction: start at 0.0265 or above",
    ),
    "unknown assembly": (
        "[stepper]",
        'assembly = "steper_gear_mass"\n[stepper]',
        'assembly: unknown "steper_gear_mass"; did you mean "stepper_gear_mass"?',
    ),
    "assembly of a wrong type": (
        "[stepper]",
        "assembly = 1\n[stepper]",
        'assembly: found 1; write assembly = "stepper_gear_mass", or leave it out',
    ),
    "unknown form": (
        "gain = 2.0",
        'gain = 2.0\nform = "papr"',
        'housing.form: unknown form "papr"; did you mean "paper"?',
    ),
    "form of a wrong type": (
        "gain = 2.0",
        "gain = 2.0\nform = true",
        'housing.form: found true; write form = "paper", or leave it out',
    ),
    "unit behind a number": (
        "coil_inductance = 0.0229",
        "coil_inductance = 22.9 mH",
        "line 6, column 24: expected newline or end of document after a statement, "
        "in 'coil_inductance = 22.9 mH'; write name = value, a number without unit and a text ",
    ),
    "table that is not closed": ("max = 5000.0 }", "max = 5000.0", "line 21, column "),
    "key twice": (
        "ratio = -50",
        "ratio = -50\nratio = 50",
        "line 21, column 11: cannot overwrite a value, in 'ratio = 50'; ",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_wrong_file_says_where_what_and_the_remedy(name, changed, refused):
    old, new, message = REFUSED[name]
    path = changed("mechanism.toml", old, new)
    refused(f"mechanism.toml: {message}", load_mechanism, path)


def test_a_number_in_place_of_a_table():
    with pytest.raises(InputFileError, match=r"^here: gear: found 5; write a table, \[gear\]$"):
        mechanism_from_table({"gear": 5}, "here")


def test_a_table_that_is_not_closed_is_said_to_need_one_line(changed):
    path = changed("mechanism.toml", "max = 5000.0 }", "max = 5000.0")
    with pytest.raises(InputFileError, match=r"; a table in \{ \} has to stand on one line$"):
        load_mechanism(path)


def test_a_missing_file_and_its_neighbour(folder):
    message = f'{folder / "mechanisn.toml"}: there is no such file; did you mean "mechanism.toml"?'
    with pytest.raises(InputFileError, match=f"^{re.escape(message)}$"):
        load_mechanism(folder / "mechanisn.toml")


def test_a_folder_is_no_mechanism(folder):
    with pytest.raises(InputFileError, match=r"cannot be read \(it is a folder\); check the path$"):
        load_mechanism(folder)


def test_a_file_in_another_encoding(folder):
    (folder / "mechanism.toml").write_bytes("[stepper]\n# 90°\n".encode("latin-1"))
    message = r"^mechanism\.toml: line 2: is not UTF-8 text; save the file as UTF-8$"
    with pytest.raises(InputFileError, match=message):
        load_mechanism(folder / "mechanism.toml")
