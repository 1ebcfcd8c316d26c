"""Every number of a budget. Truth: sums of shares, and the steady states themselves."""

import numpy as np
import pytest


def test_the_sampling_error_of_the_ensemble_is_part_of_the_band(data):
    """Truth: the band's variance, of which it has its share."""
    for row in data["requirements"]:
        share = row["variance_shares"]["draws of the ensemble"]
        assert row["sampling_sigma_rad"] == pytest.approx(row["sigma_rad"] * np.sqrt(share), rel=1e-6)
        assert row["worst_member_share"] == (0.99865 if row["interpretation"] == "temporal" else None)
    assert any(row["sampling_sigma_rad"] > 0.0 for row in data["requirements"])


def test_shares_and_cumulative_rms_add_up(data):
    """Truth: shares are parts of a whole; all lines together are the RMS."""
    for row in data["requirements"]:
        assert sum(row["variance_shares"].values()) == pytest.approx(1.0)
        assert sum(row["spread_shares"].values()) == pytest.approx(1.0)
    for mode in data["modes"][:2]:
        assert [column[-1] for column in mode["cumulative_rms_rad"]["lines"]] == pytest.approx(
            mode["line_of_sight_rms_rad"]
        )


def test_the_map_holds_the_lines_and_the_envelope_its_largest(made, data):
    """Truth: the steady states themselves."""
    scan = data["modes"][0]
    lines = np.abs(made.modes[0].responses[1].state.lines)
    np.testing.assert_allclose(scan["map"]["torque_amplitude_Nm"][1][: lines.size], lines, rtol=1e-5)
    largest = max(abs(line) for r in made.modes[0].responses for line in r.state.lines)
    top = max(scan["envelope"]["bands"], key=lambda band: band["torque_amplitude_Nm"])
    assert top["torque_amplitude_Nm"] == pytest.approx(largest)
    assert top["ci95_Nm"][0] < largest < top["ci95_Nm"][1]
