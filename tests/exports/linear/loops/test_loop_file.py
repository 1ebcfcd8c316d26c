"""The loops of quiet.toml. Truth: the entries typed here; each wrong one is refused at its place."""

import pytest

from mechid.errors import InputFileError
from mechid.exports.linear.loops.loop_file import Notch, SampledTiming, read_loop_file

CURRENT = "[current_loop]\nkp = 30.0\nki = 6000.0\nsample_rate_hz = 20000.0\n"
POSITION = "[position_loop]\nkp = 40.0\nki = 2000.0\nsample_s = 0.001\n"


def read(tmp_path, text):
    path = tmp_path / "quiet.toml"
    path.write_text(text, encoding="utf-8")
    return read_loop_file(path)


def test_both_loops_with_their_defaults(tmp_path):
    design = read(tmp_path, "bits = 8\n[range]\nfrom = 1\n" + CURRENT + "supply_V = 28.0\n" + POSITION + "notch = {}\n")
    assert design.current.timing == SampledTiming(period_s=5e-5, delay_s=5e-5)
    assert (design.current.kp, design.current.ki, design.current.supply_V) == (30.0, 6000.0, 28.0)
    assert (design.position.sensor, design.position.kd, design.position.derivative_hz) == ("output_angle", 0.0, None)
    assert design.position.timing == SampledTiming(period_s=1e-3, delay_s=1e-3)
    assert design.position.notch == Notch(frequency_hz=None, damping=0.5, depth=0.1)


def test_delays_in_seconds_and_in_samples_are_the_same(tmp_path):
    delays = [read(tmp_path, CURRENT + text).current.timing.delay_s for text in ("delay_samples=1.5", "delay_s=75e-6")]
    assert delays == pytest.approx([7.5e-5, 7.5e-5], rel=1e-12)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("bits = 8\n", r"quiet.toml: no loop; write a table \[current_loop\]"),
        ("[curent_loop]\n", 'did you mean "current_loop"'),
        ("current_loop = 3\n", r"current_loop: found 3; write a table"),
        (CURRENT + "gain = 1\n", "current_loop.gain: unknown key"),
        ("[current_loop]\nki = 1.0\nsample_s = 1e-4\n", "current_loop.kp: missing; write V/A"),
        ("[current_loop]\nkp = 0\nsample_s = 1e-4\n", "current_loop.kp: found 0, and no ki"),
        ("[current_loop]\nkp = -3.0\nsample_s = 1e-4\n", "current_loop.kp: found -3; write 0 or above"),
        ("[current_loop]\nkp = 3.0\n", "current_loop: found neither of sample_s and sample_rate_hz"),
        (CURRENT + "sample_s = 1e-4\n", "current_loop: found both of them"),
        (CURRENT + "delay_s = 1e-4\ndelay_samples = 1\n", "found delay_s and delay_samples"),
        (CURRENT + "delay_samples = 60\n", "current_loop.delay_samples: found 60 samples"),
        (CURRENT + "supply_V = 0\n", "current_loop.supply_V: found 0; write a number above 0 in V"),
        ("[position_loop]\nkp = 0\nsample_s = 1e-3\n", "position_loop.kp: found 0, and no ki or kd"),
        (POSITION + 'sensor = "motor"\n', "position_loop.sensor"),
        (POSITION + "notch = { frequency_hz = 600 }\n", "position_loop.notch.frequency_hz: found 600; write less than"),
        (POSITION + "notch = { depth = 1 }\n", "position_loop.notch.depth: found 1"),
        (POSITION + "notch = { width = 1 }\n", "position_loop.notch.width: unknown key"),
        (CURRENT + POSITION.replace("0.001", "0.00102"), "its sample period is 20.4 times"),
        (CURRENT + POSITION.replace("0.001", "0.00001"), "its sample period is 0.2 times"),
    ],
)
def test_each_wrong_entry_is_refused_at_its_place(tmp_path, text, said):
    with pytest.raises(InputFileError, match=said) as caught:
        read(tmp_path, text)
    assert caught.value.exit_code == 3
    assert "\n" not in str(caught.value)
