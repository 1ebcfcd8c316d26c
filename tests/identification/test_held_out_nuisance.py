"""Truth: held-out records made with a time offset, a gain or a supply of their own, the mechanism known.

A record that is 1.6 ms late was once predicted at the file's 0 ms without a word.
"""

import json
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

import mechid
from mechid.analysis import validate
from mechid.analysis.prediction import predict
from mechid.analysis.residual_file import residual_content
from mechid.campaign import load_campaign
from mechid.campaign.campaign import record_parameter_name
from mechid.campaign.mechanism_text import write_mechanism
from mechid.cli.app import app
from mechid.command import Command, RateProfile
from mechid.errors import UsageError
from mechid.identification.held_out_nuisance import first_part, fit_held_out_records
from mechid.identification.identify import identify, make_problem
from mechid.identification.output_error.target import target_of
from mechid.identification.result.finished_fit import campaign_as_fitted, record_as_fitted
from mechid.identification.result.fit_file import read_fit
from mechid.identification.result.grade import FitOutcome
from mechid.identification.result.search_state import SearchState
from mechid.parameter import Parameter, Status
from mechid.web.estimate import estimate_of
from synthetic import COMMANDS, NOISE_NM, RATE_HZ, campaign, displaced, measured, record, truth

LATE_S = 1.6e-3
FREE = {"gear.stiffness": 1.02, "friction.viscous": 0.97}
OFFSET = "record.held.time_offset_s"
RANGE = {"value": 0.0, "min": -5e-3, "max": 5e-3}


def late(time_offset=RANGE, *, command=COMMANDS["full_46"], seconds=1.0, late_s=LATE_S, gain=1.0):
    torque = measured(truth(), command, np.random.default_rng(2), seconds=seconds, time_offset_s=late_s)
    return record("held", gain * torque, command, time_offset=time_offset, use="validate")


def held_out_campaign(held, *, start=None):
    fitted = measured(truth(), COMMANDS["micro_46"], np.random.default_rng(1), seconds=1.0)
    return campaign(start or displaced(truth(), FREE), record("fitted", fitted, COMMANDS["micro_46"]), held)


def fitted(of):
    return identify(of, near={name: truth().value(name) for name in FREE}, workers=1)


@pytest.fixture(scope="module")
def example():
    of = held_out_campaign(late())
    return of, fitted(of)


@pytest.mark.slow
def test_the_time_offset_of_a_held_out_record_is_found_on_its_first_part(example):
    found = example[1].records["held"].nuisance
    own = found.parameters[OFFSET]
    assert own.value == pytest.approx(LATE_S, abs=3.0 * own.std_error)
    assert 0.0 < own.std_error < 1e-5
    assert found.until_s == pytest.approx(16.0 / 46.0 + RANGE["max"], abs=2e-3)  # 16 full steps, a third of this second
    assert OFFSET not in example[1].parameters


def test_its_figures_are_those_of_the_rest(example):
    of, fit = example
    channel = validate(of, fit)["held"].channels["torque"]
    assert channel.residual_rms == pytest.approx(NOISE_NM, rel=0.06)
    assert channel.fit_percent > 98.0
    assert channel.samples == fit.records["held"].samples == 10_001 - fit.records["held"].nuisance.samples
    assert channel.residual_rms == pytest.approx(fit.records["held"].residual_rms, rel=1e-3)


def test_without_a_range_nothing_is_fitted_and_the_record_is_predicted_as_declared(example):
    of = held_out_campaign(late(None))
    bare = replace(example[1], records={"fitted": example[1].records["fitted"]})
    assert fitted(of).records["held"].nuisance is None
    assert validate(of, bare)["held"].channels["torque"].fit_percent < 90.0


def test_every_prediction_takes_it(example):
    of, fit = example
    held = record_as_fitted(of.record("held"), fit)
    assert held.time_offset.value == fit.records["held"].nuisance.values[OFFSET]
    assert not held.time_offset.is_free
    p = predict(of.record("held"), fit)["torque"]
    assert p.measured.size == 10_001
    assert p.evaluated_from == fit.records["held"].nuisance.samples
    assert p.evaluated_part.base.start_s == pytest.approx(fit.records["held"].nuisance.until_s)
    assert campaign_as_fitted(of, fit).record("held").time_offset.value == pytest.approx(LATE_S, abs=1e-5)


def test_the_explorer_begins_with_it(example):
    of, fit = example
    found = estimate_of(fit, of, "here")
    assert found.values[OFFSET] == fit.records["held"].nuisance.values[OFFSET]
    assert found.sigmas[OFFSET] > 0.0


def test_the_emission_bound_holds_nothing_of_the_offset(example):
    """The lines at the step rate that a wrong offset leaves are some 0.1 N m; noise alone leaves some 0.1 mN m."""
    of, fit = example
    rates = residual_content(fit, validate(of, fit))["records"]["held"]["rates"]
    assert max(max(filter(np.isfinite, row["amplitude"])) for row in rates) < 1e-3


def test_it_is_said_and_written(example):
    fit = example[1]
    (line,) = [note for note in fit.notes if "record held" in note]
    assert "time_offset_s = 0.00159671 +- 2.1e-06 s" in line
    assert "first part" in line
    assert "those of the rest" in line
    entry = fit.to_dict()["records"]["held"]["nuisance"]
    assert entry["parameters"][OFFSET]["std_error"] > 0.0
    assert entry["until_s"] == fit.records["held"].nuisance.until_s


def test_a_supply_of_its_own_is_found_beside_the_offset():
    value = Parameter(
        name=record_parameter_name("held", "peak_voltage"),
        value=6.2,
        min=3.0,
        max=9.0,
        declaration=truth().parameters["stepper.peak_voltage"].declaration,
        status=Status.FREE,
        replaces="stepper.peak_voltage",
    )
    one = late()
    fit = fitted(held_out_campaign(replace(one, parameters=(*one.parameters, value))))
    own = fit.records["held"].nuisance.parameters
    assert own[value.name].value == pytest.approx(5.7, abs=4.0 * own[value.name].std_error)
    assert own[value.name].std_error < 0.05
    assert own[OFFSET].value == pytest.approx(LATE_S, abs=4.0 * own[OFFSET].std_error)


def test_an_offset_that_no_record_of_the_file_declares_free_is_left_alone(example):
    """The parameters that the fit has found of all records, as the clock, are no nuisance of one."""
    assert list(example[1].records["held"].nuisance.parameters) == [OFFSET]


def test_the_deepest_of_many_valleys_is_taken():
    """Microsteps at 92 steps/s swing at many frequencies: within 50 ms there are valleys by the dozen."""
    wide = {"value": 0.02, "min": -0.025, "max": 0.025}
    fit = fitted(held_out_campaign(late(wide, command=COMMANDS["full_23"], late_s=-0.0123)))
    assert fit.records["held"].nuisance.values[OFFSET] == pytest.approx(-0.0123, abs=2e-5)


def test_what_the_first_part_does_not_tell_keeps_its_value():
    """Truth: a command that rests until the last tenth of its record tells no time offset before."""
    rests = RateProfile((0.0, 0.9, 0.9), (0.0, 0.0, 46.0))
    command = Command(rate=rests, stepping="full", microsteps=1, start="equilibrium")
    of = held_out_campaign(late(RANGE, command=command, late_s=0.0))
    fit = fitted(of)
    found = fit.records["held"].nuisance
    assert found.samples == 5000  # half of it at most
    assert found.values[OFFSET] == 0.0
    assert found.parameters[OFFSET].std_error is None
    assert any("record.held.time_offset_s" in line and "does not show" in line for line in fit.warnings)


def test_an_offset_at_its_bound_is_warned_of():
    fit = fitted(held_out_campaign(late({"value": 0.0, "min": -1e-3, "max": 1e-3})))
    assert any("lies at its bound" in line for line in fit.warnings)


def test_an_interrupted_fit_leaves_it_alone_and_says_so(example):
    of, fit = example
    stopped = replace(fit, outcome=FitOutcome.INTERRUPTED, warnings=())
    found = fit_held_out_records(stopped, of, SearchState(make_problem(of, 1), np.zeros(0), {}))
    assert found.records == fit.records
    assert found.warnings == ("record held: held out, and predicted at the start values of its table",)


@pytest.mark.parametrize(
    ("rate", "seconds", "until_s"),
    [(46.0, 20.0, 2.0045), (4.0, 20.0, 4.005), (0.5, 20.0, 10.0), (92.0, 1.0, 16.0 / 92.0 + 5e-3)],
)
def test_the_first_part_is_a_tenth_and_16_steps_and_half_at_most(rate, seconds, until_s):
    command = Command(rate=RateProfile.constant(rate), stepping="full", microsteps=1)
    samples = round(seconds * RATE_HZ)
    one = record("held", np.zeros(samples), command, time_offset=RANGE, use="validate")
    assert first_part(one, target_of(one)) / RATE_HZ == pytest.approx(until_s, abs=3.0 * seconds / 20_000)


@pytest.fixture(scope="module")
def folder(tmp_path_factory, example):
    """Return a campaign in files, the result folder of its fit, and the one of a fit that declares no offset."""
    root = tmp_path_factory.mktemp("held_out")
    places = []
    for name, own in (("free", "time_offset_s = { value = 0.0, min = -5e-3, max = 5e-3 }"), ("bare", "")):
        place = root / name
        place.mkdir()
        for r in example[0].records:
            times = np.arange(r.data.samples) / RATE_HZ
            table = np.stack([times, r.data.channel("torque").data], axis=1)
            np.savetxt(place / f"{r.name}.csv", table, "%.7g", ",", header="time_s,torque_Nm", comments="")
        free = FREE_TABLE.format(own=own)
        (place / "campaign.toml").write_text(free, encoding="utf-8")
        write_mechanism(displaced(truth(), dict.fromkeys(FREE, 1.0)), place / "mechanism.toml", "")
        result = CliRunner().invoke(app, ["identify", str(place), "--out", str(place / "fit")])
        assert result.exit_code == 0, result.output
        places.append((place, result.output))
    return places


FREE_TABLE = """mechanism = "mechanism.toml"

[[record]]
name = "fitted"
file = "fitted.csv"
command = {{ stepping = "micro", microsteps = 16, rate = 46.0, start_angle_deg = 0.0 }}

[[record]]
name = "held"
file = "held.csv"
use = "validate"
command = {{ stepping = "full", rate = 46.0, start_angle_deg = 45.0 }}
{own}
"""


@pytest.mark.slow
def test_terminal_report_and_file_say_it_and_a_fit_read_again_has_it(folder):
    place, shown = folder[0]
    words = " ".join(shown.split())
    assert "record held: held out; time_offset_s = 0.00159" in words
    report = (place / "fit" / "report.md").read_text("utf-8").replace("\\", "")
    assert "Record held was held out: time_offset_s = 0.00159" in report
    fit = read_fit(place / "fit" / "estimate.json", load_campaign(place))
    content = json.loads((place / "fit" / "estimate.json").read_text("utf-8"))
    entry = content["records"]["held"]
    assert entry["nuisance"]["parameters"][OFFSET]["value"] == fit.records["held"].nuisance.values[OFFSET]
    assert entry["validation"]["judged_from_s"] == entry["nuisance"]["until_s"]
    assert entry["validation"]["channels"]["torque"]["fit_percent"] > 98.0
    again = validate(load_campaign(place), fit)["held"].channels["torque"]
    assert again.residual_rms == pytest.approx(entry["validation"]["channels"]["torque"]["residual_rms"], rel=1e-9)


@pytest.mark.slow
def test_fits_judged_by_other_parts_are_not_compared(folder):
    with pytest.raises(UsageError, match=r'record "held": judged as a whole, from 0.35\d* s on in free'):
        mechid.compare(folder[0][0] / "fit", folder[1][0] / "fit")
