"""components.json. Truth: what was written, to its six digits."""

import json
from dataclasses import replace

import numpy as np
import pytest

from fits_by_hand import fit_by_hand
from mechid.analysis.components_file import FILE_NAME, components_text, read_components
from mechid.analysis.side_components import side_lines
from mechid.errors import InputFileError
from table_of_six import MOUNTING, side_records

DRIVE = {0.5: 0.04 * np.exp(0.4j), 1.0: 0.1 * np.exp(-2.0j), 2.0: 0.03}
EXERTED = {
    "moment_z": DRIVE,
    "force_x": {1.0: 0.5 * np.exp(1.0j)},
    "force_y": {1.0: 0.2 * np.exp(2.5j), 2.0: 0.1j},
    "moment_x": {0.5: 0.01},
    "force_z": {1.25: 0.3},
}
"""At the mounting point; of force_z at an order at which the torque has no line."""


def test_the_file_holds_what_was_measured(tmp_path):
    """Truth: what was written, to its six digits; a file of another fit, or damaged, is refused."""
    records = side_records(lambda rate: EXERTED, (39.0, 41.0), np.random.default_rng(0))
    content = components_text(records, {"plant": "p"})
    (tmp_path / FILE_NAME).write_text(json.dumps(content).replace("NaN", "null"), encoding="utf-8")
    fit = fit_by_hand(None, provenance={"plant": "p"}, folder=tmp_path)
    read = read_components(fit)
    assert read.mounting == MOUNTING
    for found, true in zip(read.records, records.records, strict=True):
        assert (found.name, found.components, found.stepping) == (true.name, true.components, true.stepping)
        for a, b in zip(found.rates, true.rates, strict=True):
            np.testing.assert_allclose(a.power, b.power, rtol=1e-5, atol=1e-12)
            np.testing.assert_allclose(side_lines(a).lines, side_lines(b).lines, rtol=1e-4, atol=1e-9)
    with pytest.raises(InputFileError, match="is of another fit"):
        read_components(replace(fit, provenance={"plant": "q"}))
    (tmp_path / FILE_NAME).write_text('{"format": "mechid-components/1"}', encoding="utf-8")
    with pytest.raises(InputFileError, match="is damaged at 'orders'"):
        read_components(fit)
    assert read_components(replace(fit, folder=tmp_path / "elsewhere")) is None
