"""The electro-mechanical positioning system; truth: the benchmark's published values, and an independent fit's RMS.

A. Janot, M. Gautier, M. Brunot, Data Set and Reference Models of EMPS, Workshop on Nonlinear System Identification
Benchmarks, 2019.
"""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from mechid.analysis import validate
from mechid.campaign import load_campaign, load_mechanism
from mechid.campaign.prediction import simulate
from mechid.identification.conclude import conclude
from mechid.identification.effects.effect import add_terms
from mechid.identification.identify import make_problem
from mechid.identification.output_error.problem import transfer_values
from mechid.identification.result.grade import FitOutcome
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.solve import solve
from mechid.identification.stages.growth import warm_start
from mechid.identification.stages.needed_terms import drop_unneeded_terms
from mechid.plant.superset import superset_of
from mechid.records import ChannelSpec, RecordSpec, read_record
from mechid.reports.numbers import report_data
from mechid.reports.results import write_results
from mechid.signal.decimation import decimate

pytestmark = [pytest.mark.data, pytest.mark.slow]
PUBLISHED = {
    "mass": (95.1089, 0.1085, "kg"),
    "viscous": (203.5034, 1.146, "N s/m"),
    "coulomb": (20.3935, 0.1012, "N"),
    "offset": (-3.1648, 0.0444, "N"),
}
GAIN = 35.15065188248547


def test_inverse_dynamics_with_the_readers_channels(data_folder, figure):
    """mechid offers no inverse dynamics: this least squares is the test's, the channels are the reader's.

    The position is low-passed at 100 Hz without delay, differentiated twice, and all is decimated by 10.
    """
    from scipy.signal import butter, filtfilt

    channels = (
        ChannelSpec(quantity="force", column="vir", unit="N", gain=GAIN),
        ChannelSpec(quantity="position", column="qm", unit="m"),
    )
    record = read_record(data_folder / "EMPS" / "DATA_EMPS.mat", RecordSpec(name="e", path="e", channels=channels))
    q = filtfilt(*butter(4, 100.0, fs=record.sample_rate_hz), record.channel("position").data)
    v = np.gradient(q, record.sample_interval_s)
    columns = (np.gradient(v, record.sample_interval_s), v, np.sign(v), np.ones_like(v))
    inside = slice(50, -50)
    W = np.stack([decimate(c[inside], 10) for c in columns], axis=1)
    F = decimate(record.channel("force").data[inside], 10)
    found = np.linalg.lstsq(W, F, rcond=None)[0]
    for value, (name, (published, sigma, unit)) in zip(found, PUBLISHED.items(), strict=True):
        figure(f"EMPS: inverse dynamics, {name}", value, least=published - sigma, most=published + sigma, unit=unit)


@pytest.fixture(scope="module")
def symmetric(example, identified):
    return identified(example("emps"), "--seed", "1")[0]


@pytest.fixture(scope="module")
def by_direction(example, identified):
    return identified(example("emps_by_direction"))[0]


def test_open_loop_from_force_to_position(symmetric, figure):
    figure(
        "EMPS: force to position, symmetric friction",
        1e3 * symmetric.records["emps"].residual_rms,
        most=2.55,
        unit="mm RMS",
    )


def test_open_loop_with_friction_by_direction(by_direction, figure):
    figure(
        "EMPS: force to position, friction by direction",
        1e3 * by_direction.records["emps"].residual_rms,
        most=2.05,
        unit="mm RMS",
    )


def test_the_exact_dependence_is_reported(by_direction):
    """Truth: F_0 and Coulomb friction of both directions enter as F_0 - T_c a alone, moving and at rest."""
    frozen = {name: p.reason for name, p in by_direction.parameters.items() if p.status == "frozen"}
    dependent = [name for name, reason in frozen.items() if "the smallest singular value is" in reason]
    assert dependent == ["friction.asymmetry"]
    assert "drive.offset and friction.asymmetry" in frozen["friction.asymmetry"]
    assert set(frozen) <= {"friction.asymmetry", "load.start_rate"}  # of which the record may say less than its range


SYMMETRIC = {"load.mass": 90.5, "load.start_rate": 0.0, "drive.offset": 3.376, "friction.coulomb": 21.87}
SYMMETRIC |= {"friction.viscous": 192.0}
"""Values at which friction that is the same in both directions follows the record, 2.45 mm off."""


def test_friction_by_direction_that_a_fit_adds_is_in_all_that_is_left(example, tmp_path, figure):
    """Truth: a simulation of the mechanism file that is left, and the residual of the file that has the law.

    A search comes to terms on this record with some seeds only, so it begins at the end of a growth with them.
    """
    campaign = load_campaign(example("emps"))
    plain = make_problem(campaign, 2)
    warm, _ = warm_start(SearchState(plain, plain.start, plain.whole_windows()), SYMMETRIC)
    plain = replace(warm.problem, substeps=5)
    superset = superset_of(campaign.mechanism, grown_only=True)
    added = add_terms(superset, [term.name for term in superset.terms])
    wide = added.problem(plain)
    q = solve(
        wide,
        transfer_values(plain, plain.coordinates.point(SYMMETRIC), wide),
        wide.whole_windows(),
        steps=30,
        tolerance=1e-6,
    ).q
    state = SearchState(wide, q, wide.whole_windows(), outcome=FitOutcome.CONVERGED, searched=True, added=added)
    fit = conclude(campaign, drop_unneeded_terms(state, plain), seed=0, seconds=1.0)
    validation = validate(campaign, fit)
    write_results(fit, report_data(fit, validation=validation), tmp_path, validation=validation)
    own = json.loads((tmp_path / "estimate.json").read_text(encoding="utf-8"))["records"]["emps"]
    run = simulate(replace(campaign, mechanism=load_mechanism(tmp_path / "mechanism.toml")), "emps")
    rest = campaign.record("emps").data.channel("position").data - np.asarray(run.values["position"])
    rms = math.sqrt(float(np.mean((rest - rest.mean()) ** 2)))
    assert own["residual_rms"] == pytest.approx(rms, rel=1e-4)  # finer steps of integration
    assert own["validation"]["channels"]["position"]["residual_rms"] == pytest.approx(rms, rel=1e-6)
    assert own["followed_percent"] == 100.0
    assert own["fit_percent"] > 97.5
    assert [one.name for one in fit.missing] == ["friction.directional"]
    assert 'law = "directional"  # added by mechid' in (tmp_path / "mechanism.toml").read_text(encoding="utf-8")
    figure("EMPS: friction by direction, added by the fit", 1e3 * rms, most=2.05, unit="mm RMS")
