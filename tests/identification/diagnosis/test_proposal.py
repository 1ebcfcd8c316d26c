"""The mechanism that a diagnosis proposes: fitted to its records, and predicting those held out."""

from dataclasses import replace

import numpy as np
import pytest

from mechid.analysis.preference import ComparisonOutcome
from mechid.campaign.mechanism_file import load_mechanism
from mechid.campaign.mechanism_text import mechanism_text
from mechid.diagnoses.numbers import evidence_lines
from mechid.identification.identify import identify
from synthetic import TRUTH


def test_the_proposed_mechanism_reads_back_and_fits_with_grade_a(lacking, tmp_path):
    """Truth: the parameters that made the records, from which a fit with the proposed mechanism differs by chance."""
    bench, found = lacking
    path = tmp_path / "mechanism.toml"
    path.write_text(mechanism_text(found.mechanism))
    proposed = load_mechanism(path)
    fit = identify(replace(bench, mechanism=proposed), workers=1, near={p.name: p.value for p in proposed.free})
    assert fit.grade == "A"
    off = [abs(p.value - TRUTH[n]) / p.std_error for n, p in fit.parameters.items() if p.std_error and n in TRUTH]
    assert len(off) >= 10
    assert np.sqrt(np.mean(np.square(off))) < 2.0


def test_a_record_that_was_held_out_is_predicted_better(lacking):
    """Truth: the record has the harmonic, and its noise is all that the model with it leaves."""
    _, found = lacking
    (one,) = found.held_out
    assert one.record == "micro_92"
    assert one.before > one.after == pytest.approx(1.0, abs=0.05)
    said = evidence_lines(found)
    assert said[0].startswith("The Bayesian criterion prefers the mechanism with these effects decisively")
    assert said[-1] in (ComparisonOutcome.AGREED.value, ComparisonOutcome.UNDECIDED_BY_PREDICTION.value)
