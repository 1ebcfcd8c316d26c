"""Pictures of a diagnosis: where each effect acts, and what is left."""

import numpy as np
import pytest

from diagnosis_bench import HARMONIC, tables
from mechid.campaign.mechanism_file import mechanism_from_table
from mechid.signal.strongest import find_strongest
from synthetic import COMMANDS, RATE_HZ, TRUTH, measured


def test_where_an_effect_acts(lacking):
    """Truth: at a constant rate of full steps all repeats with the electrical period, four of them."""
    for name in ("full_46", "full_23"):
        makers = [mechanism_from_table(table, "made").with_values(TRUTH) for table in (tables(HARMONIC), tables())]
        with_it, without = (measured(m, COMMANDS[name], np.random.default_rng(1), seconds=1.0) for m in makers)
        share = find_strongest(with_it - without, RATE_HZ)  # of the same noise
        fundamental_hz, bin_hz = COMMANDS[name].rate.rates[0] / 4.0, RATE_HZ / with_it.size
        assert share.in_lines
        assert 1 <= len(share.frequencies_hz) <= 3
        off = [hz - fundamental_hz * round(hz / fundamental_hz) for hz in share.frequencies_hz]
        assert max(map(abs, off)) < 0.5 * bin_hz
    acts = lacking[1].pictures.acts["stepper.torque_harmonic:3"]
    assert all(1 <= len(one.frequencies_hz) <= 3 for one in acts.values())


def test_what_is_drawn_of_what_is_left(lacking):
    """Truth: the noise that was added to the records, which is all that the model with the effect leaves."""
    bench, found = lacking
    assert {one.record for one in found.pictures.spectra} == {r.name for r in bench.estimated}
    for one in found.pictures.spectra:
        assert np.sqrt(np.mean(one.after**2)) == pytest.approx(one.noise, rel=0.15)
        share = one.shares["stepper.torque_harmonic:3"]
        peak = int(np.argmax(share))
        before, without, after = (np.trapezoid(y**2, one.frequency_hz) for y in (one.before, share, one.after))
        assert before == pytest.approx(without + after, rel=0.02)  # at right angles, both models at their optimum
        assert one.before[peak] > 1.4 * one.after[peak]
    stretch = found.pictures.stretch
    assert stretch.record == found.pictures.spectra[0].record
    assert 0.05 <= stretch.measured.size / stretch.sample_rate_hz <= 0.3
    left = [float(np.std(stretch.measured - modelled)) for modelled in (stretch.before, stretch.after)]
    sigma = found.pictures.spectra[0].noise / np.sqrt(2.0 / stretch.sample_rate_hz)
    assert left[0] > left[1]
    assert left[1] == pytest.approx(sigma, rel=0.15)
