"""Disturbances that are no plant, found at the optimum. Truth: an independent simulator and what its recorder did."""

import re
from dataclasses import replace

import numpy as np
import pytest

from disturbed_bench import FREE, FULL, HALF, MICRO, RUNS, written
from incomplete.recording import NOISE_NM, Run
from mechid.analysis import validate
from mechid.analysis.residual_emission import TRACKED
from mechid.campaign import load_campaign
from mechid.errors import InputFileError
from mechid.identification.effects.disturbance import Disturbance
from mechid.identification.identify import _may_imitate, identify
from mechid.identification.result.estimate_file import write_estimate
from mechid.identification.result.fit_file import read_fit
from mechid.reports.numbers import report_data

HUM = {"mains_hz": 50.0, "mains_1": 3e-3, "mains_2": 1e-3, "mains_3": 1e-3}
"""Of the record: 1.5 times its noise."""


def off(fit, truth):
    """Return how far the mechanism's parameters are from the truth, in their standard errors."""
    return [abs(fit.parameters[n].value - value) / fit.parameters[n].std_error for n, value in truth.items()]


def without_option(one, *, terms=False):
    return replace(one, options=replace(one.options, disturbances="none", terms=terms))


@pytest.fixture(scope="module")
def clock(tmp_path_factory):
    """Return the folder of a bench whose recorder runs 400 ppm fast, its campaign, the truth and the fit."""
    folder = tmp_path_factory.mktemp("clock")
    one, truth = written(folder, {"clock_ppm": 400.0})
    return folder, one, truth, identify(one, workers=1, near=truth)


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """Return a campaign that nothing disturbs, the truth and the fit."""
    one, truth = written(tmp_path_factory.mktemp("undisturbed"), {})
    return one, truth, identify(one, workers=1, near=truth)


def test_a_clock_is_found_with_its_rate(clock):
    """Truth: the recorder's 400 ppm, which is 399.84 less of command time."""
    _, _, truth, fit = clock
    (found,) = fit.missing
    assert found.name == "clock"
    assert found.records == tuple(RUNS)
    assert found.p_value < 1e-9
    rate = fit.parameters["campaign.clock_ppm"]
    assert rate.value == pytest.approx(1e6 / 1.0004 - 1e6, abs=4.0 * rate.std_error)
    assert 0.0 < rate.std_error < 3.0
    assert max(off(fit, truth)) < 4.0
    assert str(fit.grade) == "A"
    assert max(r.residual_rms for r in fit.records.values()) < 1.05 * NOISE_NM
    assert any(line.startswith("clock: ") and 'disturbances = "none"' in line for line in fit.warnings)
    assert report_data(fit)["missing"][0]["rows"][0]["name"] == "campaign.clock_ppm"


@pytest.mark.parametrize(
    ("one", "may"),
    [
        (Disturbance("clock", ""), False),
        (Disturbance("record.delay", ""), True),
        (Disturbance("mains:50Hz", "", lines_hz={"a": (50.0,), "b": (50.0, 100.0)}), False),
        (Disturbance("mains:50Hz", "", lines_hz={"a": (50.0,), "b": ()}), True),
    ],
    ids=["a clock of all", "delays", "hum in two records", "hum in one"],
)
def test_only_values_of_single_records_imitate_the_mechanism(one, may):
    """Truth: the rule as docs/identification.md states it: what is in several records alike imitates no effect."""
    assert _may_imitate(one) is may


def _in_drivers_time(record):
    return replace(record, clock_reference="driver")


@pytest.mark.slow
def test_a_driver_that_is_off_is_put_right_in_the_recorders_time(tmp_path):
    """Truth: a driver whose steps come 200 ppm too soon, as an independent simulator has it, and a right recorder."""
    one, truth = written(tmp_path, {"driver_ppm": 200.0}, above="")
    fit = identify(one, workers=1, near=truth)
    (found,) = fit.missing
    assert found.name == "clock"
    rate = fit.parameters["campaign.clock_ppm"]
    assert rate.value == pytest.approx(200.0, abs=4.0 * rate.std_error)
    assert str(fit.grade) == "A"
    declared = identify(replace(one, clock_reference="recorder"), workers=1, near=truth)
    assert max(off(declared, truth)) < 3.0
    assert all(p.std_error_clock is None for p in declared.parameters.values())
    believed = replace(one, clock_reference="driver", records=tuple(map(_in_drivers_time, one.records)))
    wrong = identify(believed, workers=1, near=truth)
    assert max(off(wrong, truth)) > 5.0
    for name, value in truth.items():
        p, other = fit.parameters[name], wrong.parameters[name]
        assert p.value == pytest.approx(declared.parameters[name].value, abs=0.1 * declared.parameters[name].std_error)
        assert abs(p.value - value) < 3.0 * p.std_error
        assert p.std_error_clock == pytest.approx(abs(other.value - p.value), abs=0.2 * p.std_error_noise)
        assert p.std_error == pytest.approx(np.hypot(p.std_error_clock, declared.parameters[name].std_error), rel=0.02)
        assert p.ci95[0] < other.value < p.ci95[1]
        assert p.std_error_noise == pytest.approx(declared.parameters[name].std_error_noise, rel=0.02)
    names, moved = fit.correlation_names, np.array([wrong.parameters[n].value - fit.parameters[n].value for n in truth])
    rows = [names.index(n) for n in truth]
    beyond = (fit.covariance - declared.covariance)[np.ix_(rows, rows)]
    np.testing.assert_allclose(beyond, np.outer(moved, moved), atol=0.05 * np.max(np.abs(beyond)), rtol=0.2)
    (line,) = [line for line in fit.warnings if "clock_reference" in line]
    assert "gear.stiffness" in line or "gear.damping" in line
    assert not any("clock_reference" in line for line in declared.warnings)
    write_estimate(fit, tmp_path / "estimate.json")
    back = read_fit(tmp_path / "estimate.json", one)
    assert back.parameters == fit.parameters


@pytest.mark.slow
def test_a_clock_of_one_record_is_found_there(tmp_path):
    """Truth: the recorder's 400 ppm in one of three records, and none in the others."""
    sweep = {**MICRO, "rate_profile": [[0.0, 0.0], [4.0, 120.0]]}
    del sweep["rate"]
    runs = {"full": RUNS["full"], "half": RUNS["half"], "sweep": Run(sweep, 4.0)}
    one, truth = written(tmp_path, {}, sizes={"sweep": {"clock_ppm": 400.0}}, runs=runs)
    fit = identify(one, workers=1, near=truth)
    (found,) = fit.missing
    assert found.name == "record.clock"
    for record in runs:
        rate = fit.parameters[f"record.{record}.clock_ppm"]
        expected = 1e6 / 1.0004 - 1e6 if record == "sweep" else 0.0
        assert rate.value == pytest.approx(expected, abs=4.0 * rate.std_error)
        assert 0.0 < rate.std_error < 3.0
    assert max(off(fit, truth)) < 4.0
    assert str(fit.grade) == "A"
    assert any("record.sweep.clock_ppm = -399" in line for line in fit.warnings)
    assert report_data(fit)["missing"][0]["text"]["apart"].startswith(", most of all in sweep: -399")


@pytest.mark.slow
@pytest.mark.parametrize("terms", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_what_is_switched_off_is_not_there(clock, terms):
    """Truth: the fit without, whose residual is beyond its noise."""
    _, one, truth, _ = clock
    plain = identify(without_option(one, terms=terms), workers=1, near=truth)
    assert plain.missing == ()
    assert "campaign.clock_ppm" not in plain.parameters
    assert max(r.residual_rms for r in plain.records.values()) > 1.2 * NOISE_NM
    assert str(plain.grade) != "A"


def test_its_file_brings_it_back(clock, tmp_path):
    """Truth: the fit itself; validation and what is refitted know of the clock."""
    _, one, _, fit = clock
    write_estimate(fit, tmp_path / "estimate.json")
    back = read_fit(tmp_path / "estimate.json", one)
    assert back.missing == fit.missing
    assert back.parameters.keys() == fit.parameters.keys()
    for found in validate(one, back).values():
        assert max(v.residual_rms for v in found.channels.values()) < 1.05 * NOISE_NM
    optimum = back.optimum
    np.testing.assert_allclose(
        optimum.values(optimum.q)["campaign.clock_ppm"], fit.parameters["campaign.clock_ppm"].value, rtol=1e-3
    )


def test_what_it_says_to_declare_is_read(clock):
    """Truth: a fit with the clock declared has the same values, and nothing is missing."""
    folder, one, truth, fit = clock
    (folder / "declared.toml").write_text(one.path.read_text() + "\n" + fit.missing[0].toml)
    declared = load_campaign(folder / "declared.toml")
    again = identify(declared, workers=1, near=truth)
    assert again.missing == ()
    for name, p in again.parameters.items():
        if p.std_error:
            assert p.value == pytest.approx(fit.parameters[name].value, abs=0.05 * p.std_error)


def test_a_complete_campaign_stays_as_it_is(undisturbed):
    """Truth: the same fit where none is allowed, to the last bit."""
    one, truth, with_all = undisturbed
    plain = identify(without_option(one), workers=1, near=truth)
    assert with_all.missing == ()
    assert {n: (p.value, p.std_error) for n, p in with_all.parameters.items()} == {
        n: (p.value, p.std_error) for n, p in plain.parameters.items()
    }
    np.testing.assert_array_equal(with_all.covariance, plain.covariance)


@pytest.mark.slow
def test_supplies_are_found_with_their_mean_as_the_files(undisturbed, tmp_path):
    """Truth: the supplies of the simulator, whose mean is the file's."""
    supplies = (1.010, 0.996, 0.994)
    one, truth = written(tmp_path, {}, supplies=supplies)
    fit = identify(one, workers=1, near=truth)
    (found,) = fit.missing
    assert (found.name, found.dof) == ("record.voltage", 2)
    known = one.mechanism.value("stepper.peak_voltage")
    for name, supply in zip(RUNS, supplies, strict=True):
        own = fit.parameters[f"record.{name}.peak_voltage"]
        assert own.value == pytest.approx(supply * known, abs=4.0 * own.std_error_noise)
        assert own.std_error_noise < 1e-3 * known
    assert max(off(fit, truth)) < 4.0
    _, _, alone = undisturbed
    for name in truth:
        assert fit.parameters[name].std_error_noise < 1.6 * alone.parameters[name].std_error_noise, name


@pytest.mark.slow
def test_a_mean_of_supplies_that_is_off_is_within_the_errors(tmp_path):
    """Truth: the simulator's supplies, whose mean is 0.7 % above the file's and whose scatter s makes it s / sqrt(3).

    What is seen of the supply is the torque constant's, once, and twice the resistance's and the inductance's.
    """
    supplies = np.array([1.016, 1.004, 1.001])
    one, truth = written(tmp_path, {}, supplies=tuple(supplies), free=(*FREE, "stepper.coil_inductance"))
    fit = identify(one, workers=1, near=truth)
    unknown = supplies.std(ddof=1) / np.sqrt(3.0)
    powers = {"stepper.torque_constant": 1.0, "stepper.coil_resistance": 2.0, "stepper.coil_inductance": 2.0}
    for name, power in powers.items():
        p = fit.parameters[name]
        assert p.std_error == pytest.approx(power * unknown * p.value, rel=0.1)
        assert p.std_error_noise < 0.25 * p.std_error
        assert p.dof == pytest.approx(2.0, rel=0.1)  # of three supplies
        assert abs(p.value - truth[name]) < 2.0 * p.std_error
        assert abs(p.value - truth[name]) > 5.0 * p.std_error_noise
    gear = fit.parameters["gear.stiffness"]
    assert gear.dof is None
    assert gear.std_error < 1.2 * gear.std_error_noise
    pair = [fit.correlation_names.index(name) for name in ("stepper.torque_constant", "stepper.coil_inductance")]
    assert abs(fit.correlation[tuple(pair)]) > 0.95


@pytest.mark.slow
def test_declared_mains_are_removed_where_the_grid_is(tmp_path):
    """Truth: hum of 50.02 Hz, as large as the noise, under records that say mains = 50.0; one at 1.5 orders of it."""
    hum = {"mains_hz": 50.02, "mains_1": 2e-3, "mains_2": 1e-3, "mains_3": 1e-3}
    micro = Run({**MICRO, "rate": 47.3}, 6.0)
    runs = {"full": Run({**FULL, "rate": 33.3467}, 3.0), "half": Run(HALF, 3.0), "micro": micro}
    one, truth = written(tmp_path, hum, runs=runs, above="")
    one = replace(one, options=replace(one.options, mains=50.0))
    fit = identify(one, workers=1, near=truth)
    assert fit.mains_hz == pytest.approx(50.02, abs=2e-3)
    assert max(r.residual_rms for r in fit.records.values()) < 1.02 * NOISE_NM
    assert max(off(fit, truth)) < 4.0
    for record in fit.records.values():
        assert [hz for hz in record.lines if hz < 60.0] == pytest.approx([50.02], abs=5e-3)
    write_estimate(fit, tmp_path / "estimate.json")
    back = read_fit(tmp_path / "estimate.json", one)
    assert back.mains_hz == fit.mains_hz
    for at in validate(one, back)["full"].channels["torque"].emission:
        assert np.isnan(at.amplitude[TRACKED.index(1.5)])
        assert np.nanmax(at.amplitude / at.sigma) < 5.0
    bare = replace(one, options=replace(one.options, mains=None, disturbances="none"))
    assert identify(bare, workers=1, near=truth).mains_hz == pytest.approx(50.02, abs=2e-3)


def test_hum_is_projected_out_and_listed(tmp_path):
    """Truth: frequency and amplitudes of the simulator's hum."""
    one, truth = written(tmp_path, HUM, runs={**RUNS, "micro": Run({**MICRO, "rate": 47.3}, 0.8)})
    fit = identify(one, workers=1, near=truth)
    (found,) = fit.missing
    assert found.name == "mains:50Hz"
    assert found.parameters["campaign.mains_hz"].value == pytest.approx(50.0, abs=0.02)
    for name in RUNS:
        for k in (1, 2, 3):
            line = found.parameters[f"record.{name}.mains_{k}"]
            assert line.value == pytest.approx(HUM[f"mains_{k}"], abs=5.0 * line.std_error)
        assert fit.records[name].residual_rms == pytest.approx(NOISE_NM, rel=0.03)
    assert max(off(fit, truth)) < 4.0
    for prediction in validate(one, fit).values():
        assert max(v.residual_rms for v in prediction.channels.values()) < 1.05 * NOISE_NM
    (tmp_path / "declared.toml").write_text((tmp_path / "campaign.toml").read_text() + found.toml)
    again = identify(load_campaign(tmp_path / "declared.toml"), workers=1, near=truth)
    assert again.missing == ()
    assert again.records["micro"].residual_rms == pytest.approx(fit.records["micro"].residual_rms, rel=1e-3)


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ('disturbances = "clocks"', 'identify.disturbances: found "clocks"'),
        ('disturbances = ["clock", "supply"]', 'identify.disturbances[1]: found "supply"'),
        ("mains = 55.0", "identify.mains: found 55; write 50 or 60"),
    ],
)
def test_a_wrong_option_is_refused(tmp_path, entry, message):
    """Truth: the place and the words."""
    written(tmp_path, {})
    text = (tmp_path / "campaign.toml").read_text()
    (tmp_path / "wrong.toml").write_text(text.replace("[[record]]", f"[identify]\n{entry}\n[[record]]", 1))
    with pytest.raises(InputFileError, match=re.escape(message)):
        load_campaign(tmp_path / "wrong.toml")
