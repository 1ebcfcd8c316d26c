"""design.toml: what it says is what is asked for, and what is wrong is answered with its place."""

import pytest

from mechid.designs.design_file import DesignOptions, options_for, read_design_file
from mechid.errors import InputFileError

WHOLE = """
seed = 3
[recording]
noise_Nm = 0.005
sample_rate_hz = 5000.0
duration_s = 2.0
durations_s = { full_46 = 0.5 }
[candidates]
steppings = ["micro", "full"]
microsteps = 64
rates = [23.0, 46.0]
start_angles_deg = [45.0]
durations_s = [0.5, 1.0]
sweeps_s = []
sweep_to = 200.0
[limits]
total_s = 60.0
between_s = 0.0
torque_Nm = 1.0
most_of_one = 2
keep = ["full_46"]
risk = 0.1
departing = 0.3
[criterion]
kind = "gear.damping"
over = "low"
[prior]
mechanisms = 4
"""


def written(tmp_path, text):
    path = tmp_path / "design.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_every_key_is_read(tmp_path):
    """Truth: the text itself."""
    read = read_design_file(written(tmp_path, WHOLE))
    assert (read.seed, read.criterion, read.over, read.mechanisms) == (3, "gear.damping", "low", 4)
    r, c, limits = read.recording, read.candidates, read.limits
    assert (r.noise_Nm, r.sample_rate_hz, r.duration_s, dict(r.durations_s)) == (0.005, 5000.0, 2.0, {"full_46": 0.5})
    assert (c.steppings, c.microsteps, c.rates, c.start_angles_deg) == (("full", "micro"), 64, (23.0, 46.0), (45.0,))
    assert (c.durations_s, c.sweeps_s, c.sweep_to) == ((0.5, 1.0), (), 200.0)
    assert (limits.total_s, limits.between_s, limits.torque_Nm, limits.most_of_one) == (60.0, 0.0, 1.0, 2)
    assert (limits.keep, limits.risk, limits.departing) == (("full_46",), 0.1, 0.3)


def test_without_a_file_and_with_an_empty_one_it_is_the_usual(tmp_path):
    """Truth: the defaults."""
    assert options_for(tmp_path / "campaign.toml") == DesignOptions()
    empty = read_design_file(written(tmp_path, ""))
    assert (empty.candidates, empty.limits, empty.criterion) == (
        DesignOptions().candidates,
        DesignOptions().limits,
        "D",
    )
    assert options_for(tmp_path / "campaign.toml").criterion == "D"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[limits]\ntotals = 3.0", 'design.toml: limits.totals: unknown key; did you mean "total_s"'),
        ("[limits]\nrisk = 2.0", "design.toml: limits.risk: found 2; write a share from 0 to 1"),
        ("[limits]\nbetween_s = -1.0", "design.toml: limits.between_s: found -1; write 0 or above in s"),
        ("[candidates]\nrates = [0.0]", "design.toml: candidates.rates[0]: found 0; write a number above 0"),
        ("[candidates]\nrates = 3.0", "design.toml: candidates.rates: found 3.0; write numbers, such as [23.0, 46.0]"),
        ('[candidates]\nsteppings = ["fulll"]', 'candidates.steppings[0]: found "fulll"; did you mean "full"'),
        ("[prior]\nmechanisms = 0", "design.toml: prior.mechanisms: found 0; write a whole number from 1 to 1024"),
        ("[recording]\nnoise_Nm = 0.0", "design.toml: recording.noise_Nm: found 0; write a number above 0"),
        ("[recording]\ndurations_s = 1.0", "design.toml: recording.durations_s: found 1.0; write a table"),
        ("limits = 1", "design.toml: limits: found 1; write a table [limits]"),
        ("[criterion]\nkind = 1", 'design.toml: criterion.kind: found 1; write "D", "A", "E" or the name'),
    ],
)
def test_what_is_wrong_is_one_line_with_place_and_remedy(tmp_path, text, message):
    with pytest.raises(InputFileError) as caught:
        read_design_file(written(tmp_path, text))
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
