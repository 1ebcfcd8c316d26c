"""Benches of hardware sizes: their draws, their two simulators, and the counts of what is searched for."""

import json
import math
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import incomplete_benches
from incomplete import by_events, plant, searches
from incomplete.benches import TRUTH_NAME, drawn, make_bench
from incomplete.hardware import HARDWARE, PAIRS, runs_at_resonance
from incomplete.names import names_of
from incomplete.recording import Run, recorded, resonance_hz
from incomplete.search_summary import is_followed, is_named, reaches_chaos, search_table
from incomplete.searches import line_of
from incomplete.sizes import SIZES, SMALL
from mechid.campaign import load_campaign, mechanism_from_table, mechanism_text
from paper import constant
from recovery.mechanisms import FAMILIES
from runs import base, rms, run_kernel, run_twin

SIZED = SIZES["hardware"]
FULL = {"stepping": "full", "rate": 46.0, "start_angle_deg": 45.0}
MICRO = {"stepping": "micro", "microsteps": 16, "rate": 46.0}
SHORT = {"full": Run(FULL, 0.1), "micro": Run(MICRO, 0.1)}
SUPPLY_V = 5.7
TURN = 2.0 * np.pi
RANGES = {
    "phase_offset": {"offset_A": (0.0, 0.03 * SUPPLY_V), "offset_B": (0.0, 0.03 * SUPPLY_V)},
    "imbalance": {"r_R": (0.01, 0.025), "r_L": (0.01, 0.025), "r_k": (0.01, 0.025)},
    "gain_apart": {"gain": (0.0, 0.03)},
    "gain_common": {"gain_common": (0.0, 0.03)},
    "torque_harmonic": {"harmonic": (0.0, 0.06)},
    "torque_harmonic_between": {"harmonic": (0.0, 0.06)},
    "detent": {"detent_3": (1e-3, 6e-3), "detent_order_3": (1, 400)},
    "detent_between": {"detent_3": (1e-3, 6e-3), "detent_order_3": (1, 400)},
    "kinematic_error": {"kinematic": (30e-6, 200e-6), "kinematic_order": (1, 8)},
    "stribeck": {"stribeck_rate": (1.0, 4.0)},
    "backlash": {"backlash": (0.1e-3, 0.4e-3)},
    "output_friction": {"output_coulomb": (0.0, 20e-3)},
    "load_dependent_friction": {"load_share": (0.05, 0.2)},
    "friction_over_angle": {"angle_share": (0.1, 0.3)},
    "anti_alias": {"alias_w": (TURN * 1200.0, TURN * 2500.0)},
    "charge_amplifier": {"amplifier_s": (0.3, 0.8)},
    "mains_hum": {"mains_1": (2e-3, 6e-3), "mains_hz": (50.0, 60.0)},
    "clock": {"clock_ppm": (0.0, 200.0)},
    "trigger": {"trigger_s": (0.0, 1e-3)},
    "supply_apart": {"supply": (0.3e-2, 2e-2)},
    "quantisation": {"resolution": (2e-3, 10e-3)},
}
"""Magnitudes in SI units, orders per turn of the rotor, as asked for or as the table says."""
TOLD_BEFORE = {"synthetic", "effect", "seed", "size", "parameters", "in_library"}


@pytest.mark.parametrize("effect", HARDWARE)
def test_sizes_are_within_what_hardware_has(effect):
    """Truth: the ranges that were asked for, typed a second time. In 200 draws both ends are come near."""
    sizes = [drawn(effect, seed, sizes=SIZED)[1] for seed in range(200)]
    for key, (low, high) in RANGES[effect].items():
        own = np.abs([size[key] for size in sizes if key in size])
        assert own.min() >= low * (1.0 - 1e-12)
        assert own.max() <= high * (1.0 + 1e-12)
        assert own.max() > 0.8 * high
        assert own.min() < 0.35 * high or own.min() < 1.3 * low
    assert HARDWARE[effect].reason


def test_the_page_has_every_effect_with_its_reason():
    """Truth: the table of the page on validation."""
    page = " ".join((Path(__file__).parents[2] / "docs" / "validation.md").read_text(encoding="utf-8").split())
    rows = [f"| {effect.words} | {effect.reason} |" for effect in HARDWARE.values()]
    assert [row for row in rows if row not in page] == []


def test_orders_are_whole_and_none_that_the_mechanism_has():
    """Truth: detents of 1.8 and 3.6 deg are 200 and 100 periods in a turn; the other family has one name for each."""
    for effect in ("detent", "detent_between"):
        orders = {drawn(effect, seed, sizes=SIZED)[1]["detent_order_3"] for seed in range(300)}
        assert all(order.is_integer() for order in orders)
        assert not orders & {100.0, 200.0}
        assert {order % 50 == 0 for order in orders} == {effect == "detent"}


@pytest.mark.slow
def test_the_first_family_draws_what_it_drew(tmp_path):
    """Truth: a bench written before there was a second family: its size, a parameter, three samples of a record."""
    sizes = replace(SMALL, runs=lambda mechanism, rng: dict(list(SMALL.runs(mechanism, rng).items())[:3]))
    bench = make_bench("supply_apart+mains_hum", 3, tmp_path, sizes=sizes)
    assert bench.truth["stepper.coil_inductance"] == pytest.approx(0.02959716032842295, rel=1e-14)
    size = {
        "supply": 0.004474398398760661,
        "mains_hz": 60.0,
        "mains_1": 0.0017384505057308037,
        "mains_2": 0.00012353340521252448,
        "mains_3": 0.00020825643240876828,
    }
    assert bench.size == pytest.approx(size, rel=1e-14)
    assert json.loads((tmp_path / TRUTH_NAME).read_text()).keys() == TOLD_BEFORE
    torque = np.loadtxt(tmp_path / "full_slow.csv", delimiter=",", skiprows=1, usecols=1)
    assert torque[[0, 5000, 10000]] == pytest.approx([0.002249803878, -0.02752014986, -0.006588967785], abs=1e-9)


@pytest.mark.slow
def test_equal_seeds_give_equal_benches_of_either_simulator(tmp_path):
    """Truth: the files of the first, byte by byte; the fifth seed is by the second simulator."""
    sizes = replace(SIZED, runs=lambda _mechanism, _rng: SHORT)
    for seed, simulator in ((0, "plant"), (4, "by_events")):
        folders = [tmp_path / f"{name}{seed}" for name in "ab"]
        for folder in folders:
            make_bench("gain_apart+detent", seed, folder, sizes=sizes, catalogue=True)
        for path in sorted(folders[0].iterdir()):
            assert path.read_bytes() == (folders[1] / path.name).read_bytes(), path.name
        told = json.loads((folders[0] / TRUTH_NAME).read_text())
        assert told["simulator"] == simulator
        assert told["names"] == names_of("gain_apart+detent", told["size"])
        assert len({one["gain"] for one in told["records"].values()}) == 2
        assert all(abs(one["gain"] - 1.0) <= told["size"]["gain"] for one in told["records"].values())
        campaign = load_campaign(folders[0])
        catalogue = FAMILIES[1].catalogue()
        assert all(p.value == catalogue.value(p.name) for p in campaign.mechanism.free)
        assert campaign.record("full").command.start_angle_deg == 45.0


def test_runs_are_about_the_resonance_and_begin_at_rest():
    """Truth: the resonance of the load on the gear's spring; a sweep of 20 s that begins at rate 0."""
    mechanism, _ = drawn("nothing", 2, sizes=SIZED)
    resonance = resonance_hz(mechanism)
    for seed in range(20):
        runs = runs_at_resonance(mechanism, np.random.default_rng(seed))
        assert len(runs) == 6
        assert abs(runs["full_res"].command["rate"] / resonance - 1.0) < 0.09
        assert abs(runs["micro_res"].command["rate"] / resonance - 1.0) < 0.06
        share = resonance / runs["full_sub"].command["rate"]
        assert min(abs(share / 2.0 - 1.0), abs(share / 3.0 - 1.0)) < 0.06
        assert runs["sweep"].seconds == 20.0
        assert runs["sweep"].command["rate_profile"][0] == [0.0, 0.0]


@pytest.mark.parametrize("stepping", SHORT)
def test_the_second_simulator_is_the_kernel(stepping):
    """Truth: mechid's kernel, which shares no code with it."""
    mechanism, _ = drawn("nothing", 1, sizes=SIZED)
    command = constant(46.0) if stepping == "full" else constant(46.0, microsteps=16, start_angle_deg=0.0)
    own = recorded(mechanism, {}, Run(SHORT[stepping].command, 0.4), None, simulate=by_events.run).torque_Nm
    torque = run_kernel(mechanism, command, base(0.4), substeps=8).torque
    assert rms(own - torque) < 1e-5 * rms(torque)


QUICK = ("imbalance", "stribeck", "mains_hum")
"""Of the motor, of the friction and of the recording; `make test-slow` has every effect."""


@pytest.mark.parametrize(
    "effect",
    [one if one in QUICK else pytest.param(one, marks=pytest.mark.slow) for one in (*HARDWARE, *PAIRS)],
)
def test_the_simulators_agree(effect):
    """Truth: one another; they share no equation. A thousandth of the noise, over what can be predicted."""
    mechanism, size = drawn(effect, 3, sizes=SIZED)
    for one in SHORT.values():
        first, second = (
            recorded(mechanism, size, one, None, simulate=simulate).torque_Nm for simulate in (plant.run, by_events.run)
        )
        assert rms(first - second) < 2e-6
        assert rms(first) > 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("simulate", [plant.run, by_events.run], ids=["plant", "by_events"])
@pytest.mark.parametrize("over", ["rotor", "output"])
def test_friction_over_an_angle_is_the_librarys(over, simulate):
    """Truth: the library's block in the slow twin, integrated to 1e-10, no code of which is shared."""
    draws = (drawn("friction_over_angle", seed, sizes=SIZED) for seed in range(20))
    mechanism, size = next(one for one in draws if one[1]["angle_of_rotor"] == (over == "rotor"))
    table = tomllib.loads(mechanism_text(mechanism))
    order, phase = round(TURN / size["angle_period"]), math.degrees(size["angle_phase"])
    entry = {"order": order, "amplitude": size["angle_share"], "phase_deg": phase}
    table["friction"] |= {"position" if over == "rotor" else "output_position": [entry]}
    twin = run_twin(mechanism_from_table(table, "mechanism.toml"), constant(46.0), base(0.05))
    own = recorded(mechanism, size, Run(FULL, 0.05), None, simulate=simulate).torque_Nm
    assert rms(own - np.ravel(twin.y)) < 1e-5 * rms(own)


def test_the_second_simulator_refuses_what_it_has_not():
    """Truth: effects of the first family that hardware's table lacks."""
    mechanism, size = drawn("gear_hysteresis", 0)
    with pytest.raises(ValueError, match="hysteresis_stiffness"):
        recorded(mechanism, size, SHORT["full"], None, simulate=by_events.run)


def test_a_gear_with_much_backlash_cannot_be_predicted(tmp_path):
    """Truth: chaos: a change of 1e-12 becomes as large as the torque within a second. Other records are predictable."""
    for effect, lost in (("backlash", True), ("output_friction", False)):
        sizes = replace(SIZED, runs=lambda _mechanism, _rng: {"double": Run({**MICRO, "rate": 92.0}, 1.0)})
        make_bench(effect, 0, tmp_path / effect, sizes=sizes)
        predictable = json.loads((tmp_path / effect / TRUTH_NAME).read_text())["predictable_s"]["double"]
        assert (predictable is not None) == lost


def searched(effect, seed, *, missing=(), z=1.0, grade="B", followed=100.0, cpu_s=30.0, predictable=True):
    """Return the line of a search, as `search_bench` gives it; each parameter is z stated errors off."""
    estimate = {
        "outcome": {"code": "converged"},
        "grade": grade,
        "records": {"sweep": {"horizon_s": 0.3, "channels": {"torque": {"followed_percent": followed}}}},
        "missing": [{"name": one[0], "aliases": one[1:], "share": 1.0, "parameters": {}} for one in missing],
        "parameters": {
            "gear.stiffness": {
                "value": 1000.0 + z,
                "unit": "N m/rad",
                "std_error": 1.0,
                "std_error_noise": 1.0,
                "status": "free",
            }
        },
    }
    bench = {"effect": effect, "seed": seed, "size": drawn(effect, seed, sizes=SIZED)[1], "simulator": "plant"}
    ran = {"exit": 0, "cpu_s": cpu_s, "wall_s": cpu_s, "said": []}
    foreseen = {"predictable_s": {"sweep": None if predictable else 0.5}}
    return {**bench, **foreseen, **ran, **line_of(estimate, {"gear.stiffness": 1000.0})}


def test_a_line_tells_what_is_named_and_followed():
    """Truth: names by hand. An alias counts; a second name does not; nothing is right where nothing is missing."""
    assert is_named(searched("clock", 0, missing=[("clock",)]))
    assert is_named(searched("clock", 0, missing=[("record.clock",)]))
    assert is_named(searched("phase_offset", 0, missing=[("stepper.detent:7.2deg",)]))
    assert is_named(searched("stribeck", 0, missing=[("friction.directional", "friction.stribeck")]))
    assert not is_named(searched("clock", 0, missing=[("clock",), ("record.delay",)]))
    assert not is_named(searched("clock", 0))
    assert is_named(searched("quantisation", 0))
    assert is_named(searched("nothing", 0))
    assert not is_named(searched("nothing", 0, missing=[("clock",)]))
    both = [("stepper.imbalance",), ("stepper.phase_offset",)]
    assert is_named(searched("phase_offset+imbalance", 0, missing=both))
    assert not is_named(searched("phase_offset+imbalance", 0, missing=both[:1]))
    assert searched("clock", 0, z=-2.5)["z"] == {"gear.stiffness": pytest.approx(-2.5)}
    assert is_followed(searched("clock", 0))
    assert not is_followed(searched("clock", 0, followed=99.0))
    assert not is_followed(searched("clock", 0, grade="C"))


def test_a_chaotic_record_is_followed_as_far_as_the_truth_can_be():
    """Truth: 0.3 s reached of 0.5 s; a record that is lost although it can be predicted to its end."""
    assert reaches_chaos(searched("backlash", 0, followed=1.5, predictable=False))
    assert not reaches_chaos(searched("backlash", 0, followed=1.5))
    assert reaches_chaos(searched("clock", 0))


def test_names_depend_on_what_was_drawn():
    """Truth: by hand."""
    of_rotor, of_output = ({"angle_of_rotor": own, "angle_period": TURN / k} for own, k in ((1.0, 3), (0.0, 33)))
    assert names_of("friction_over_angle", of_rotor) == ["friction.position:3"]
    assert names_of("friction_over_angle", of_output) == ["friction.position:output:33"]
    assert names_of("detent_between", {"detent_order_3": 7.0}) == ["stepper.detent:51.4deg"]
    assert names_of("gain_apart+trigger", {}) == ["record.gain", "record.delay"]


def test_the_table_holds_the_searches_against_what_is_asked():
    """Truth: three of four followed, one of these 4 sigma off; one false name of three; a pair not followed."""
    lines = [
        searched("clock", 0, missing=[("clock",)], cpu_s=20.0),
        searched("clock", 1, missing=[("clock",)], z=4.0, cpu_s=40.0),
        searched("detent", 0, missing=[("record.delay",)], cpu_s=60.0),
        searched("backlash", 0, grade="C", followed=1.5, cpu_s=300.0, predictable=False),
        searched("detent+mains_hum", 0, grade="C"),
    ]
    table = search_table(lines)
    for row in (
        "followed, A or B:   75.0%  asked 92%",
        "families below 67%:  backlash 0 of 1",
        "median 50.0, asked 45; worst 300.0, asked 200",
        "exactly the missing effect:   50.0%  asked 85%",
        "false names:   33.3%  asked at most 5%",
        "parameters within 3 sigma:   66.7%  asked 95%",
        "two effects, followed, A or B:    0.0%  asked 80%",
        "not predictable to their ends by the true model itself: 1 of 5 (backlash); followed for 50% of what is: 1",
    ):
        assert row in table
    (clock,) = (row for row in table.splitlines() if row.startswith("clock "))
    assert "2 (100%)" in clock
    assert "50.0%" in clock


def test_searches_are_taken_up_where_they_were_left(tmp_path, monkeypatch, capsys):
    """Truth: the file, which holds one of two benches, and a search that would say so."""
    line = searched("clock", 0, missing=[("clock",)])
    (tmp_path / "searches.jsonl").write_text(json.dumps(line) + "\n")
    made = []

    def search(effect, seed, sizes, workers, _keep):
        made.append((effect, seed, sizes.name, workers))
        return searched(effect, seed, missing=[("stepper.detent:7.2deg",)])

    monkeypatch.setattr(incomplete_benches, "search_bench", search)
    command = ["incomplete_benches.py", "--sizes", "hardware", "--catalogue", "--effects", "clock", "phase_offset"]
    monkeypatch.setattr("sys.argv", [*command, "--seeds", "0:1", "--out", str(tmp_path)])
    incomplete_benches.main()
    assert made == [("phase_offset", 0, "hardware", 1)]
    assert len((tmp_path / "searches.jsonl").read_text().splitlines()) == 2
    assert "followed, A or B:  100.0%" in capsys.readouterr().out


def test_what_the_command_cannot_do_is_said(monkeypatch, capsys):
    """Truth: by hand: hardware's benches are fitted from the catalogue alone, and have their own effects."""
    for options, said in ((["--sizes", "hardware"], "--catalogue"), (["--effects", "trigger"], "'trigger' is none of")):
        monkeypatch.setattr("sys.argv", ["incomplete_benches.py", *options])
        with pytest.raises(SystemExit):
            incomplete_benches.main()
        assert said in capsys.readouterr().err


def test_the_command_is_run_and_read(tmp_path, monkeypatch):
    """Truth: the command's own file, of a bench whose campaign it refuses: no fit, and what it said."""
    monkeypatch.setattr(searches, "make_bench", lambda _effect, _seed, folder, **_: unfit(folder))
    line = searches.search_bench("clock", 0, SIZED, 1, tmp_path / "estimate.json")
    assert (line["exit"], line["grade"], line["missing"]) == (3, "failed", [])
    assert line["cpu_s"] > 0.1
    assert "no record" in " ".join(line["said"])
    assert not is_followed(line)


def unfit(folder):
    """Write a bench whose campaign names a mechanism file that is not there, and no record."""
    truth = {"effect": "clock", "seed": 0, "size": {}, "simulator": "plant", "in_library": True, "predictable_s": {}}
    (folder / TRUTH_NAME).write_text(json.dumps({**truth, "parameters": {}}))
    (folder / "campaign.toml").write_text('mechanism = "mechanism.toml"\n')
