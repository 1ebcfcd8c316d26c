"""The false discovery rate. Truth: the example of Benjamini and Hochberg's paper, and the rate over drawn fleets."""

import math

import numpy as np

from mechid.fleets import significance
from mechid.fleets.regression import random_effects_mean

REJECTED = [0.0001, 0.0004, 0.0019, 0.0095]
PAPER = [*REJECTED, 0.0201, 0.0278, 0.0298, 0.0344, 0.0459, 0.3240, 0.4262, 0.5719, 0.6528, 0.7590, 1.0]
"""Table of section 4.1 of J. R. Stat. Soc. B 57 (1995) 289: at 0.05 four are rejected, by Bonferroni three."""


def test_the_example_of_the_paper():
    found = [one.found for one in significance.apply_fdr(PAPER, 0.05, lambda p: p)]
    assert found == [True] * 4 + [False] * 11


def test_what_was_no_test_is_no_finding_and_costs_nothing():
    with_none = significance.apply_fdr([*PAPER, math.nan], 0.05, lambda p: p)
    assert [one.q for one in with_none[:-1]] == significance.q_values(PAPER)
    assert math.isnan(with_none[-1].q)
    assert not with_none[-1].found


def test_of_parameters_of_correlated_estimates_the_share_of_false_findings_is_kept():
    """12 units, 15 parameters, of which 5 differ; estimates of a unit are correlated by up to 0.9. 150 fleets."""
    rng, shares, power = np.random.default_rng(8), [], []
    for _ in range(150):
        mixing = rng.standard_normal((15, 3))
        covariance = mixing @ mixing.T + 0.3 * np.eye(15)
        scale = np.sqrt(np.diag(covariance))
        values = rng.multivariate_normal(np.zeros(15), covariance / np.outer(scale, scale), 12).T
        values[:5] += 1.5 * rng.standard_normal((5, 12))
        found = [
            one.found
            for one in significance.apply_fdr(
                [random_effects_mean(v, np.ones(12)) for v in values], 0.05, lambda m: m.equal_p
            )
        ]
        shares.append(sum(found[5:]) / max(sum(found), 1))
        power.append(sum(found[:5]) / 5.0)
    assert np.mean(shares) < 0.05
    assert np.mean(power) > 0.7
