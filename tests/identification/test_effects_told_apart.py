"""Which effects a diagnosis names: those that explain the records, told from those that stand for something else."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import mechid
from diagnosis_bench import HARMONIC, made, tables
from mechid.campaign import catalogue_mechanism
from mechid.campaign.catalogue_values import CATALOGUE
from mechid.campaign.mechanism_file import mechanism_from_table
from mechid.command import RateProfile
from mechid.identification.diagnosis import search
from mechid.identification.diagnosis.diagnosis import diagnose
from mechid.identification.diagnosis.search import in_doubt, small_in_part, standing_in
from mechid.identification.diagnosis.start import begun
from mechid.identification.diagnosis.steps import exchange_effect
from mechid.identification.diagnosis.stretches import in_stretches
from mechid.identification.effects.scores import Score
from mechid.identification.identify import identify
from synthetic import COMMANDS, RATE_HZ, TRUTH, campaign, measured, record


def test_a_high_pass_that_hides_in_the_noise_is_found():
    """Truth: the time constant of the charge amplifier that the records went through."""
    table = {**CATALOGUE, "charge_amplifier": {"time_constant": 1.0}}
    made_by = mechanism_from_table(table, "with a charge amplifier").with_values(TRUTH)
    records = [
        record(n, measured(made_by, COMMANDS[n], np.random.default_rng((9, k)), seconds=0.3), COMMANDS[n])
        for k, n in enumerate(("full_46", "full_23", "micro_46"))
    ]
    bench = replace(campaign(catalogue_mechanism(), *records), considered=("charge_amplifier", "clock"))
    found = diagnose(bench, identify(bench, workers=1, near=TRUTH), workers=1)
    assert [one.name for one in found.missing] == ["charge_amplifier"]
    own = found.missing[0].parameters["charge_amplifier.time_constant"]
    assert abs(own.value - 1.0) < 4.0 * own.std_error < 0.5


@pytest.mark.slow
def test_a_detent_that_no_list_has_is_named_with_its_period():
    """Truth: the detent of 137 periods in a turn, 4 mN m and 30 deg, that made the records; a sweep of 8 s shows it."""
    third = {"period_deg": 360.0 / 137.0, "amplitude": 0.004, "phase_deg": 30.0}
    stepper = {**CATALOGUE["stepper"], "detent": [*CATALOGUE["stepper"]["detent"], third]}
    made_by = mechanism_from_table({**CATALOGUE, "stepper": stepper}, "with a third detent").with_values(TRUTH)
    rising = replace(COMMANDS["micro_46"], rate=RateProfile.through([(0.0, 0.0), (8.0, 110.0)]))
    commands = {"full_46": (COMMANDS["full_46"], 1.0), "micro_46": (COMMANDS["micro_46"], 1.0), "sweep": (rising, 8.0)}
    records = [
        record(n, measured(made_by, command, np.random.default_rng((5, k)), seconds=seconds), command)
        for k, (n, (command, seconds)) in enumerate(commands.items())
    ]
    bench = campaign(catalogue_mechanism(), *records)
    found = diagnose(bench, identify(bench, workers=1, near=TRUTH), workers=1)
    (one,) = found.missing
    assert one.name == "stepper.detent:2.63deg"
    own = {name.rpartition(".")[2]: p for name, p in one.parameters.items()}
    assert abs(own["amplitude"].value - 0.004) < 4.0 * own["amplitude"].std_error < 1e-4
    assert abs(own["phase_deg"].value - 30.0) < 4.0 * own["phase_deg"].std_error < 2.0


def test_hum_that_the_fit_has_found_is_named():
    """Truth: 50 Hz of 5 mN m with a third of it at 150 Hz, added to a record whose rate varies."""
    command = replace(COMMANDS["micro_46"], rate=RateProfile.through([(0.0, 10.0), (2.0, 60.0)]))
    made_by = catalogue_mechanism().with_values(TRUTH)
    torque = measured(made_by, command, np.random.default_rng(9), seconds=2.0)
    turns = 2.0 * np.pi * 50.0 * np.arange(torque.size) / RATE_HZ
    torque += 5e-3 * (np.sin(turns) + np.sin(3.0 * turns) / 3.0)
    bench = replace(campaign(made_by, record("sweep", torque, command)), considered=("clock",))
    fit = identify(bench, workers=1, near={p.name: p.value for p in made_by.free})
    assert [one.name for one in fit.missing] == ["mains:50Hz"]
    found = diagnose(bench, fit, workers=1)
    assert [one.name for one in found.missing] == ["mains:50Hz"]


def test_effects_that_stand_for_something_else_are_told_from_those_that_explain():
    """Truth: the rule as the documentation has it: a half where more than noise is left, and three that imitate."""

    def score(share):
        return Score(chi_square=1000.0, dof=1, share=share, worth=1e5)

    def left(ratio):
        return SimpleNamespace(over_noise=ratio)

    assert standing_in(left(1.0), {"a": score(0.9), "b": score(0.2)}) == []
    assert standing_in(left(1.05), {"a": score(0.9), "b": score(0.2)}) == ["b"]
    assert standing_in(left(1.0), {"a": score(0.9), "b": score(0.2), "c": score(0.2)}) == []
    assert standing_in(left(1.0), {"a": score(0.9), "b": score(0.2), "c": score(0.05)}) == ["c"]
    assert standing_in(left(1.0), {"a": score(0.9), **dict.fromkeys("bcd", score(0.2))}) == ["a", "b", "c", "d"]
    five = dict.fromkeys("abcd", score(0.9))
    assert standing_in(left(1.0), {**five, "e": score(0.9)}) == []
    assert standing_in(left(1.0), {**five, "e": score(0.2)}) == ["a", "b", "c", "d", "e"]


def test_effects_with_which_parts_of_the_records_disagree_are_named_where_they_take_nearly_all(monkeypatch):
    """Truth: the rule that the page states, at both sides of each limit."""

    def score(share):
        return Score(1000.0, 2, share, 1e5)

    def left(over_noise):
        return SimpleNamespace(over_noise=over_noise, cost=1.0)

    needed, less = {"a": score(0.95), "b": score(0.8)}, {"a": left(1.3), "b": left(1.3)}
    monkeypatch.setattr(search, "_agrees", lambda model: True)
    assert in_doubt(left(1.0), needed, less) == []
    monkeypatch.setattr(search, "_agrees", lambda model: False)
    assert in_doubt(left(1.0), needed, less) == ["b"]
    assert in_doubt(left(1.0), needed, {**less, "a": left(1.005)}) == ["a", "b"]
    assert in_doubt(left(1.3), needed, less) == []
    assert in_doubt(left(1.0), {}, {}) == []


def test_a_small_effect_is_not_named_of_records_followed_in_part():
    """Truth: less than a hundredth of what the largest explains is small, of whole records never."""
    needed = {
        name: SimpleNamespace(chi_square=c) for name, c in {"a": 1e5, "b": 1001.0, "c": 999.0, "d": 500.0}.items()
    }
    part, whole = (SimpleNamespace(is_of_whole_records=one) for one in (False, True))
    assert small_in_part(part, needed) == "d"
    assert small_in_part(part, {name: needed[name] for name in "ab"}) == ""
    assert small_in_part(part, {}) == ""
    assert small_in_part(whole, needed) == ""


def test_effects_are_found_from_the_first_moments_on(fitted):
    """Truth: the harmonic that made the records, five times that of the fit's, whose values are none of these."""
    bench = made({**HARMONIC, "amplitude": 0.05})
    before, _ = begun(bench, fitted[1].to_dict())
    told = []
    found = in_stretches(replace(before, q=before.problem.start, cost=np.inf), told.append)
    assert found.effects == ("stepper.torque_harmonic:3",)
    assert found.over_noise == pytest.approx(1.0, abs=0.03)
    assert found.is_of_whole_records
    values = found.problem.coordinates.values(found.q)
    (amplitude,) = (v for n, v in values.items() if "torque_harmonic" in n and n.endswith("amplitude"))
    assert amplitude == pytest.approx(0.05, rel=0.05)
    assert told[0].endswith("% of the records followed with nothing beside")
    assert told[-1] == "100.0 % of the records followed with stepper.torque_harmonic:3"


def test_a_fit_on_a_wrong_branch_holds_no_parameter(fitted):
    """Truth: the mechanism file, which says what is free; the fit has held one of these."""
    bench, fit = fitted
    estimate = fit.to_dict()
    held = {**estimate["parameters"]["gear.damping"], "status": "frozen"}
    estimate = {**estimate, "parameters": {**estimate["parameters"], "gear.damping": held}, "grade_reasons": []}

    def free(grade):
        return {p.name for p in begun(bench, {**estimate, "grade": grade})[0].base.free}

    assert free("C") == {p.name for p in bench.mechanism.free}
    assert free("C") - free("B") == {"gear.damping"}


def test_a_law_stands_beside_another(fitted):
    """Truth: the parameters that each law has of its own, and the values with which the first one stood there."""
    bench, fit = fitted
    before, _ = begun(bench, fit.to_dict())
    friction = next(law for law in before.other_laws if law.name == "output_friction")
    one = before.in_place_of(friction, friction.mechanism.with_values({"output_friction.coulomb": 0.0123}))
    backlash = next(law for law in one.other_laws if law.name == "gear.backlash")
    both = one.in_place_of(backlash, backlash.mechanism)
    assert both.laws == ("output_friction", "gear.backlash")
    assert set(both.law_parameters) == {*friction.own, *backlash.own}
    assert both.base.value("output_friction.coulomb") == 0.0123
    assert "output_friction" not in {law.name for law in both.other_laws}
    assert set(before.base.parameters) < set(one.base.parameters) < set(both.base.parameters)


def test_an_alias_is_found_from_where_the_other_effect_is():
    """Truth: offsets of the phase voltages and a detent of 7.2 deg are one, so that either leaves the same."""
    imbalance = {"offset_a": 0.06, "offset_b": -0.04}
    made_by = mechanism_from_table({**tables(), "stepper": {**CATALOGUE["stepper"], "imbalance": imbalance}}, "apart")
    made_by = made_by.with_values(TRUTH)
    records = [
        record(n, measured(made_by, COMMANDS[n], np.random.default_rng((3, k)), seconds=0.3), COMMANDS[n])
        for k, n in enumerate(("full_46", "micro_46"))
    ]
    bench = campaign(catalogue_mechanism(), *records)
    before, _ = begun(bench, mechid.identify(bench, workers=1, near=TRUTH).to_dict())
    detent = before.fitted(before).with_effect("stepper.detent:7.2deg")
    offset = exchange_effect(detent, "stepper.detent:7.2deg", "stepper.phase_offset")
    assert offset.terms == ("stepper.phase_offset",)
    assert offset.cost == pytest.approx(detent.cost, abs=3.0)
    values = offset.problem.coordinates.values(offset.q)
    found = {name.rpartition(".")[2]: value for name, value in values.items() if "offset_" in name}
    assert found == pytest.approx(imbalance, rel=0.05)


def backwards_after(bench, seconds):
    """Return a campaign whose records run backwards after some time, which no mechanism follows."""
    first = round(seconds * RATE_HZ)

    def one(made_record):
        (channel,) = made_record.data.channels
        torque = np.array(channel.data)
        torque[first:] = torque[first:][::-1]
        return replace(made_record, data=replace(made_record.data, channels=(replace(channel, data=torque),)))

    return replace(bench, records=tuple(map(one, bench.records)))


@pytest.mark.slow
def test_what_is_missing_is_named_from_what_can_be_followed(fitted):
    """Truth: the harmonic that made the records up to 0.2 s of 0.3; nothing made what comes after that."""
    bench = backwards_after(made({**HARMONIC, "amplitude": 0.05}), 0.2)
    estimate = {**fitted[1].to_dict(), "grade": "C", "grade_reasons": []}
    found = diagnose(bench, estimate, workers=1)
    assert [one.name for one in found.missing] == ["stepper.torque_harmonic:3"]
    assert 0.6 < found.share < 0.7
    assert f"the first {100.0 * found.share:.3g} % of all samples" in found.words
    (amplitude,) = (p for n, p in found.missing[0].parameters.items() if n.endswith("amplitude"))
    assert abs(amplitude.value - 0.05) < 4.0 * amplitude.std_error
