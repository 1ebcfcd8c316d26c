"""Optimum of a fit rebuilt from its campaign. Truth: the fit itself, and what an earlier version of the code gave."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from finished import identified
from mechid.errors import FitError, InputFileError, UsageError
from mechid.identification.refit.bootstrap import bootstrap
from mechid.identification.refit.profile import profiles
from mechid.identification.refit.rebuild import changed_files
from mechid.identification.result.estimate_file import write_estimate
from mechid.identification.result.fit_file import read_fit
from mechid.identification.result.grade import Grade

FREE = ("housing.gain", "housing.frequency", "housing.damping")
GAIN = "housing.gain"
BEFORE = {
    "q": [1.5259775374531408, 8.62707783297965, -2.3504555684831487],
    "draws": [
        (2018.4585372778738, [4.599931519413273, 5587.647577129229, 0.09461868608126703]),
        (1965.392619006605, [4.600934082784158, 5574.03161755762, 0.09657760823020746]),
        (1980.3920238228598, [4.602288228136481, 5575.989954504916, 0.09579155183982986]),
    ],
    "profile": [
        (4.58716406456231, 4.000343790771694),
        (4.58965650442563, 2.560821269073813),
        (4.5921504263407025, 1.4400450686589465),
        (4.594641757113369, 0.640695183319167),
        (4.597143687884472, 0.1589875828174172),
        (4.599637690476252, 0.0),
        (4.602131693068031, 0.1607871627370514),
        (4.60461958324836, 0.6405446488042799),
        (4.607111475489067, 1.4407980175813009),
        (4.609603416770182, 2.559484298673624),
        (4.612098437068848, 4.001076748192418),
    ],
}
"""Point, cost and values of three draws, value and rise of each point of the profile, before the rebuilding of a fit
was made one function. The code gives the same to the last digit; another processor rounds otherwise."""


@pytest.fixture(scope="module")
def fit():
    return identified(*FREE)


def test_the_optimum_is_where_the_fit_is(fit):
    optimum = fit.optimum
    assert optimum.estimated_names == FREE
    for name, value in optimum.values(optimum.q).items():
        p = fit.parameters[name]
        assert abs(value - p.value) < 0.01 * p.std_error
    assert optimum.problem.substeps == fit.provenance["substeps"]


def test_refits_are_those_of_the_earlier_version(fit):
    optimum = fit.optimum_on(1)
    np.testing.assert_allclose(optimum.q, BEFORE["q"], rtol=1e-9)
    found = bootstrap(optimum, 3, seed=1)
    assert optimum.triangle.cost == pytest.approx(2001.0, rel=1e-9)  # as many samples, each of its noise's size
    for draw, (cost, values) in zip(found.draws, BEFORE["draws"], strict=True):
        assert draw.cost == pytest.approx(cost, rel=1e-7)
        np.testing.assert_allclose(list(draw.values.values()), values, rtol=1e-7)
    (profile,) = profiles(optimum, [GAIN])
    np.testing.assert_allclose([(p.value, p.rise) for p in profile.points], BEFORE["profile"], rtol=1e-6, atol=1e-6)


def test_a_fit_that_was_read_has_the_same_optimum_to_the_last_digit(fit, tmp_path):
    write_estimate(fit, tmp_path / "estimate.json")
    read = read_fit(tmp_path, fit.campaign).optimum_on(2)
    here = fit.optimum_on(1)
    assert read.q.tolist() == here.q.tolist()
    assert read.triangle.cost == here.triangle.cost
    assert read.triangle.jacobian.tolist() == here.triangle.jacobian.tolist()
    assert read.windows == here.windows


def test_the_optimum_is_kept_by_the_fit_alone(fit):
    first = fit.optimum_on(1)
    assert fit.optimum_on(2).triangle is first.triangle
    assert fit.optimum_on(2).problem.workers == 2
    assert vars(pickle.loads(pickle.dumps(fit))).keys() == vars(replace(fit)).keys()
    moved = replace(fit.parameters[GAIN], value=4.6)
    other = replace(fit, parameters={**fit.parameters, GAIN: moved})
    assert other.optimum_on(1).triangle is not first.triangle


def test_a_pickled_fit_rebuilds_the_same_optimum(fit):
    again = pickle.loads(pickle.dumps(fit))
    assert again.optimum_on(1).q.tolist() == fit.optimum_on(1).q.tolist()


def test_a_fit_without_its_campaign_is_refused(fit):
    with pytest.raises(UsageError, match="does not hold its campaign; give campaign="):
        _ = replace(fit, campaign=None).optimum


def test_a_fit_of_grade_c_has_no_optimum(fit):
    with pytest.raises(FitError, match=r"can be refitted; this one: Grade C"):
        _ = replace(fit, grade=Grade.C).optimum


def test_a_campaign_of_other_files_is_refused(fit):
    digests = dict.fromkeys(fit.inputs_sha256, "0" * 64)
    other = replace(fit, provenance={**fit.provenance, "inputs_sha256": digests})
    assert changed_files(fit.campaign, fit) == ()
    assert changed_files(fit.campaign, other) == tuple(digests)
    with pytest.raises(InputFileError, match="changed since the fit; identify anew"):
        _ = other.optimum
