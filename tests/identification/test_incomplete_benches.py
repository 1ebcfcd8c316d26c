"""Benches with one effect left out: their simulator, what the effects do, and the command that fits and counts them."""

import json
import math
import tomllib
from dataclasses import replace

import numpy as np
import pytest

import incomplete_benches
from incomplete import by_events, plant
from incomplete.benches import drawn, make_bench, true_record
from incomplete.effects import EFFECTS
from incomplete.recording import Run, recorded
from incomplete.summary import complete_table, contrasts_of, incomplete_table
from mechid.campaign import load_campaign, mechanism_from_table, mechanism_text
from mechid.identification.identify import identify
from mechid.identification.stages.whole_records import WHOLE_RECORDS
from paper import constant
from recovery.mechanisms import FAMILIES
from runs import base, rms, run_kernel, run_twin

FULL = {"stepping": "full", "rate": 46.0, "start_angle_deg": 45.0}
MICRO = {"stepping": "micro", "microsteps": 16, "rate": 46.0}
COMMANDS = {"full": (FULL, constant(46.0)), "micro": (MICRO, constant(46.0, microsteps=16, start_angle_deg=0.0))}
RISING = {"stepping": "micro", "microsteps": 16, "rate_profile": [[0.0, 20.0], [0.3, 120.0]]}


@pytest.mark.parametrize("stepping", COMMANDS)
def test_without_effect_the_simulator_is_the_kernel(stepping):
    """Truth: the kernel, which shares no code with it."""
    mechanism, _ = drawn("detent", 1)
    as_mapping, command = COMMANDS[stepping]
    own = true_record("detent", 1, as_mapping, 0.4, with_effect=False).torque_Nm
    torque = run_kernel(mechanism, command, base(0.4), substeps=8).torque
    assert rms(own - torque) < 1e-5 * rms(torque)


def friction(law):
    """Return what a size changes of the friction's table, its law and one key of it."""

    def change(table, size):
        (value,) = size.values()
        table["friction"] |= {"law": law, {"stribeck": "stribeck_rate", "load_dependent": "load_share"}[law]: value}

    return change


def _detent(table, s):
    table["stepper"]["detent"].append(
        {
            "period_deg": 360.0 / s["detent_order_3"],
            "amplitude": s["detent_3"],
            "phase_deg": math.degrees(s["detent_phase_3"]),
        }
    )


def _harmonic(owner, key, name):
    def change(table, s):
        entry = {"order": int(s[f"{name}_order"]), "amplitude": s[name], "phase_deg": math.degrees(s[f"{name}_phase"])}
        table[owner] |= {key: [entry]}

    return change


def _imbalance(table, s):
    keys = {
        "r_R": "resistance",
        "r_L": "inductance",
        "r_k": "torque_constant",
        "offset_A": "offset_a",
        "offset_B": "offset_b",
    }
    table["stepper"]["imbalance"] = {keys[name]: value for name, value in s.items()}


def _output_friction(table, s):
    table["output_friction"] = {"coulomb": s["output_coulomb"], "stiction": s["output_stiction"], "viscous": 0.0}


BLOCKS = {
    "detent": _detent,
    "torque_harmonic": _harmonic("stepper", "torque_harmonic", "harmonic"),
    "imbalance": _imbalance,
    "phase_offset": _imbalance,
    "inductance_over_angle": lambda table, s: table["stepper"].update(saliency={"share": s["inductance_share"]}),
    "detent_hysteresis": lambda table, s: table["stepper"].update(
        detent_hysteresis={"torque": s["lag_torque"], "angle_deg": math.degrees(s["lag_angle"])}
    ),
    "kinematic_error": _harmonic("gear", "kinematic_error", "kinematic"),
    "backlash": lambda table, s: table["gear"].update(law="backlash", backlash=s["backlash"]),
    "output_friction": _output_friction,
    "stribeck": friction("stribeck"),
    "load_dependent_friction": friction("load_dependent"),
    "charge_amplifier": lambda table, s: table.update(charge_amplifier={"time_constant": s["amplifier_s"]}),
    "anti_alias": lambda table, s: table.update(anti_alias={"frequency": s["alias_w"], "order": int(s["alias_order"])}),
}
"""How the library's blocks are told of an effect."""


@pytest.mark.slow
@pytest.mark.parametrize("simulate", [plant.run, by_events.run], ids=["plant", "by_events"])
@pytest.mark.parametrize("effect", BLOCKS)
def test_an_effect_of_the_library_is_the_librarys(effect, simulate):
    """Truth: the library's block in the slow twin, integrated to 1e-10, no code of which is shared.

    Where the torque jumps (a flank is met, the output sticks) the library's sample is the mean over its interval: one
    sample in a hundred is left out.
    """
    mechanism, size = drawn(effect, 1)
    if simulate is by_events.run and size.keys() & by_events.ABSENT:
        pytest.skip("the second simulator has hardware's effects alone")
    table = tomllib.loads(mechanism_text(mechanism))
    BLOCKS[effect](table, size)
    twin = run_twin(mechanism_from_table(table, "mechanism.toml"), constant(46.0), base(0.05))
    own = recorded(mechanism, size, Run(FULL, 0.05), None, simulate=simulate).torque_Nm
    least = np.sort(np.abs(own - np.ravel(twin.y)))[: -own.size // 100]
    assert rms(least) < 1e-5 * rms(own)


@pytest.mark.parametrize("effect", EFFECTS)
def test_every_effect_shows_in_the_torque(effect):
    """Truth: the same run without it; noise, offset and drift are the same ones."""
    mechanism, size = drawn(effect, 0)
    with_it, without = (
        recorded(mechanism, chosen, Run(RISING, 0.3), np.random.default_rng(1)).torque_Nm for chosen in (size, {})
    )
    assert rms(with_it - without) > 2e-5


def test_what_the_mechanism_does_is_without_the_instruments():
    """Truth: the same mechanism without its effect, which is one of the recorder."""
    plain = true_record("mains_hum", 0, MICRO, 0.1, with_effect=False).torque_Nm
    assert np.array_equal(true_record("mains_hum", 0, MICRO, 0.1).torque_Nm, plain)
    assert not np.array_equal(true_record("mains_hum", 0, MICRO, 0.1, as_recorded=True).torque_Nm, plain)
    assert true_record("detent", 0, MICRO, 0.1, sample_rate_hz=20_000.0).time_s.size == 2001


def test_two_effects_at_once_are_both_there():
    """Truth: the same mechanism with either of their sizes left away; the recorder's is none of the mechanism."""
    mechanism, size = drawn("detent+clock", 0)
    assert size.keys() == drawn("detent", 0)[1].keys() | {"clock_ppm"}
    assert drawn("detent+clock", 0, of_rig=False)[1].keys() == drawn("detent", 0)[1].keys()
    both = recorded(mechanism, size, Run(RISING, 0.3), None).torque_Nm
    for less in ({"clock_ppm": 0.0}, {"detent_3": 0.0}):
        assert rms(both - recorded(mechanism, {**size, **less}, Run(RISING, 0.3), None).torque_Nm) > 2e-5
    assert drawn("nothing", 0)[1] == {}
    for wrong in ("detent+detent", "detent+detent_between", "detents"):
        with pytest.raises(ValueError, match="detent"):
            drawn(wrong, 0)


def test_equal_seeds_give_equal_benches(tmp_path):
    """Truth: the files of the first, byte by byte; another seed draws another mechanism and size."""
    first, again = (make_bench("detent", 0, tmp_path / name) for name in "ab")
    for path in sorted(first.folder.iterdir()):
        assert path.read_bytes() == (again.folder / path.name).read_bytes(), path.name
    mechanism, size = drawn("detent", 1)
    assert size != first.size
    assert all(mechanism.value(name) != value for name, value in first.truth.items())
    written = json.loads((first.folder / "truth.json").read_text())
    assert written["parameters"] == dict(first.truth)
    assert written["size"] == dict(first.size)


def parameter(value, truth, std_error, **others):
    """Return a parameter's entry of a line."""
    entry = {"unit": "ohm", "std_error_noise": 0.1, "dof": None, "status": "free"} | others
    reach = 1.959964 * std_error
    return {"value": value, "truth": truth, "std_error": std_error, "ci95": [value - reach, value + reach], **entry}


def line(effect, parameters, *, part="whole", grade="B", agrees=False, rho=0.0):
    """Return a fit's line; every two errors correlate alike."""
    own = {f"p{k}": p for k, p in enumerate(parameters)}
    matrix = [[1.0 if i == j else rho for j in range(len(own))] for i in range(len(own))]
    return {
        "effect": effect,
        "seed": 0,
        "part": part,
        "size": {},
        "outcome": "converged",
        "grade": grade,
        "correlation": {"names": list(own), "matrix": matrix},
        "cpu_s": 3.0,
        "wall_s": 4.0,
        "concluding_s": 1.0,
        "parameters": own,
        "agrees": agrees,
    }


def test_the_table_counts_what_lies_within_the_errors():
    """Truth: errors of 1, 2.5 and, on the circle, 4 sigmas; a fit of grade A is not counted. Halves 1 sigma apart."""
    angle = parameter(179.0, -179.0, 0.5, unit="deg")
    lines = [
        line("detent", [parameter(2.0, 1.0, 1.0), parameter(3.5, 1.0, 1.0)]),
        line("backlash", [angle]),
        line("clock", [parameter(90.0, 1.0, 1.0)], grade="A", agrees=True),
        line("detent", [parameter(1.0, 9.0, 3.0)], part="first"),
        line("detent", [parameter(6.0, 9.0, 4.0)], part="second"),
    ]
    rows = incomplete_table(lines).splitlines()
    stated = next(row for row in rows if row.startswith("stated"))
    assert f"RMS z {math.sqrt((1.0 + 6.25 + 16.0) / 3.0):7.2f}" in stated
    assert "within 2  33.3%" in stated
    assert "within 3  66.7%" in stated
    assert "worst p0 -4.0" in stated
    assert "3 benches with one effect left out: 1 A, 2 B; gate opened in 2 of 3" in rows[1]
    halves = next(row for row in rows if row.startswith("halves, stated"))
    assert f"RMS z {1.0:7.2f}" in halves


def test_sums_and_differences_are_counted_by_the_correlation():
    """Truth: by hand, errors of 1 and 2.5 that correlate by 0.28: 3.5 over 1.6 and -1.5 over 1.2."""
    sums, less = contrasts_of(line("detent", [parameter(2.0, 1.0, 1.0), parameter(3.5, 1.0, 1.0)], rho=0.28))
    assert sums == [("p0 + p1", pytest.approx(3.5 / 1.6))]
    assert less == [("p0 - p1", pytest.approx(-1.5 / 1.2))]


def test_complete_campaigns_are_counted_by_noise():
    """Truth: one of two campaigns holds its value."""
    lines = [line("", [parameter(2.0, 1.0, 1.0)], agrees=True), line("", [parameter(4.0, 1.0, 1.0)], grade="A")]
    table = complete_table([{**own, "noise": kind} for own, kind in zip(lines, ("white", "hum"), strict=True)])
    assert "complete, all: 2 campaigns: 1 A, 1 B; gate opened in 1 of 2" in table
    assert "within 2  50.0%" in table


def test_what_is_in_the_folder_is_not_fitted_again(tmp_path, monkeypatch, capsys):
    """Truth: the folder, whose second line a killed run left unfinished, and a fit that would say so."""
    fits = tmp_path / "fits.jsonl"
    held = line("detent", [parameter(2.0, 1.0, 1.0)])
    fits.write_text(json.dumps(held) + "\n" + '{"effect": "de')
    made = []
    monkeypatch.setattr(
        incomplete_benches, "fits_of", lambda *key: made.append(key[:3]) or [{**held, "effect": "clock"}]
    )
    command = ["incomplete_benches.py", "--effects", "detent", "clock", "--seeds", "0:1", "--out", str(tmp_path)]
    monkeypatch.setattr("sys.argv", command)
    incomplete_benches.main()
    assert made == [("clock", 0, ["whole"])]
    assert [own["effect"] for own in incomplete_benches.read(fits)] == ["detent", "clock"]
    assert "2 benches with one effect left out" in capsys.readouterr().out


@pytest.mark.slow
def test_a_friction_that_imitates_another_is_replaced_by_it(tmp_path):
    """Truth: the bench's size; growth past a stall adds friction by direction, which leaves more than noise."""
    bench = make_bench("load_dependent_friction", 1000, tmp_path)
    fit = identify(replace(load_campaign(bench.folder), mechanism=FAMILIES[1].catalogue()))
    assert fit.path[-1] == WHOLE_RECORDS
    (entry,) = fit.missing
    assert entry.name == "friction.load_dependent"
    share = entry.parameters["friction.load_share"]
    assert abs(share.value - bench.size["load_share"]) < 4.0 * share.std_error
    assert max(record.residual_over_noise for record in fit.records.values()) < 1.05
