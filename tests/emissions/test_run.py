"""Verdicts of whole campaigns. Truth: the lines that were written into the records, and their noise."""

import numpy as np
import pytest

import mechid
from emission_bench import background, record, requirement, samples, write_campaign
from mechid.errors import InputFileError

LINES = ((46.0, 0.05), (92.0, 0.02))


def judged(folder, *wanted, lines=LINES, beside=(), seconds=8.0):
    runs = {"run": samples(1, (*lines, *beside)), "off": samples(2, beside, seconds)}
    return mechid.emission(write_campaign(folder, runs, record("run", 46.0), background(), *wanted))


@pytest.mark.parametrize(
    ("limit", "verdict"), [(0.1, "pass"), (0.0505, "pass"), (0.049, "fail"), (0.0501, "not_shown"), (2e-4, "fail")]
)
def test_a_line_passes_or_fails_where_its_bounds_show_it(tmp_path, limit, verdict):
    """Truth: a line of 0.05 N; its standard error is sqrt(2 0.01^2 1.5 / 16000) N, 1.4e-4."""
    found = judged(tmp_path, requirement(mask=((20.0, limit), (500.0, limit))))
    assert found.assessments[0].verdict == verdict
    if verdict != "not_shown":
        assert found.assessments[0].judged.worst.frequency_hz == pytest.approx(46.0, abs=0.2)


def test_lines_have_their_order_and_peak_value(tmp_path):
    found = judged(tmp_path, requirement())
    own = [one for one in found.lines if one.direction == "fy"]
    assert [one.order for one in own] == [1.0, 2.0]
    for one, (frequency, peak) in zip(own, LINES, strict=True):
        assert one.frequency_hz == pytest.approx(frequency, abs=0.05)
        assert one.amplitude == pytest.approx(peak, abs=4.0 * one.sigma)
        assert one.sigma == pytest.approx(np.sqrt(2.0 * 0.01**2 * 1.5 / 16000.0), rel=0.7)


def test_mains_count_until_they_are_declared_and_are_named(tmp_path):
    hum = ((50.0, 0.05), (100.0, 0.02))
    wanted = [
        requirement(name, mask=((20.0, 0.06), (500.0, 0.06)), more=m)
        for name, m in (("with", ""), ("out", "exclude_mains = true"))
    ]
    found = judged(tmp_path, *wanted, lines=((46.0, 0.03),), beside=hum)
    assert [one.verdict for one in found.assessments] == ["not_decidable", "pass"]
    assert any("mains at 50, 100 Hz" in note and "left out of out as declared" in note for note in found.notes)


def test_a_density_is_that_of_the_run_less_the_background(tmp_path):
    """Truth: white noise of 0.01 N over 1000 Hz is 1e-7 N^2/Hz; three times the variance leaves twice that."""
    runs = {"run": samples(1, noise=0.01 * np.sqrt(3.0), seconds=40.0), "off": samples(2, seconds=40.0)}
    wanted = requirement(kind="psd", unit="N^2/Hz", mask=((50.0, 1e-6), (700.0, 1e-6)))
    found = mechid.emission(write_campaign(tmp_path, runs, record("run", 46.0), background(), wanted))
    worst = found.assessments[0].judged.worst
    assert found.assessments[0].verdict == "pass"
    assert 2e-7 < worst.value < 5e-7  # the largest of 650 bins


def test_the_torque_is_the_moment_about_the_drive_axis(tmp_path):
    found = judged(tmp_path, requirement(direction="torque", unit="mN*m", mask=((20.0, 40.0), (500.0, 40.0))))
    assert found.assessments[0].verdict == "fail"
    assert {one.direction for one in found.lines} == {"fx", "fy", "fz", "mx", "my", "mz"}


def test_a_direction_that_no_record_has_is_refused(tmp_path):
    np.savetxt(tmp_path / "run.csv", samples(1)[:, :1], header="torque_Nm", comments="")
    (tmp_path / "campaign.toml").write_text(
        'mechanism = "none.toml"\n[[record]]\nname = "run"\nfile = "run.csv"\nsample_rate_hz = 2000.0\n'
        'command = { stepping = "full", rate = 46.0 }\n' + requirement()
    )
    with pytest.raises(InputFileError, match=r'requirement\[0\].direction: no record measures "fx"; they have torque'):
        mechid.emission(tmp_path)
