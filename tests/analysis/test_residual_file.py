"""residual.json. Truth: the lines put into a residual, read back from the content of the file."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from layouts import LAYOUTS, paper_with
from mechid.analysis.residual_emission import TRACKED, residual_emission
from mechid.analysis.residual_file import residual_content, residual_records

RATE_HZ, RATE = 200.0, 46.0


def stored(mechanism):
    """Return a fit and its validation, with a residual of one line: at the first mesh if the mechanism has one."""
    travel = RATE * np.arange(8000) / RATE_HZ
    named = mechanism.named_lines
    line = 0.01 * np.sin(2 * np.pi * (named[0].order if named else 0.5) * travel)
    emission = residual_emission(line, travel, RATE_HZ, named=named)
    channel = SimpleNamespace(emission=emission, spectrum_hz=np.array([0.0, RATE_HZ / 2]))
    command = {"stepping": "full", "microsteps": 1}
    fitted = SimpleNamespace(
        reading=SimpleNamespace(left_out=False), channels={"torque": SimpleNamespace(noise_sigma=1e-3)}
    )
    fit = SimpleNamespace(mechanism=mechanism, records={"a": fitted}, provenance={})
    return fit, {"a": SimpleNamespace(channels={"torque": channel}, command=command)}


def test_a_line_of_a_mesh_is_read_back_at_its_order():
    fit, validation = stored(paper_with(LAYOUTS["tooth mesh"]))
    (record,) = residual_records(fit, validation)
    at, k = record.rates[0], len(TRACKED) + record.named.index("mesh 1")
    assert at.orders[k] == pytest.approx(74 / 200)
    assert at.amplitude[k] == pytest.approx(0.01, rel=1e-3)
    assert len(at.orders) == len(at.amplitude) == len(TRACKED) + len(record.named)


def test_a_mechanism_without_meshes_leaves_the_file_as_it_was():
    fit, validation = stored(paper_with({}))
    content = json.loads(json.dumps(residual_content(fit, validation)))
    assert set(content["records"]["a"]) == {"stepping", "microsteps", "noise_sigma", "sample_rate_hz", "rates"}
    (record,) = residual_records(fit, validation)
    np.testing.assert_array_equal(record.rates[0].orders, TRACKED)
