"""A servo's torque ripple as a look sees it. Truth: the lines of an independent look, in the data's own index."""

import json

import pytest

pytestmark = pytest.mark.data


@pytest.fixture(scope="module")
def channel(data_folder, tmp_path_factory):
    """Return the speed of the servo at 60 turns a minute, as look.json has it."""
    from typer.testing import CliRunner

    from mechid.cli.app import app

    path, out = next((data_folder / "torque_ripple" / "PI-QLR-SDM251").glob("*.dcexp")), tmp_path_factory.mktemp("look")
    result = CliRunner().invoke(app, ["look", str(path), "--quantity", "rotor_rate", "--out", str(out)])
    assert result.exit_code == 0, result.output
    (record,) = json.loads((out / "look.json").read_text())["records"]
    return record["channels"][0]


def test_the_sixth_order_is_the_largest_line(channel, figure):
    largest = max(channel["lines"], key=lambda line: line["amplitude"])
    figure("torque ripple: order 6 at 60 turns a minute", largest["frequency_hz"], least=5.9, most=6.1, unit="Hz")
    assert largest["amplitude"] > 20.0 * largest["sigma"]


def test_lines_are_at_whole_orders_of_the_turn(channel, figure):
    """One turn a second: of the lines, but for those beside order 6 that its switched control makes, all are whole."""
    orders = {round(line["frequency_hz"]) for line in channel["lines"] if abs(line["frequency_hz"] % 1.0 - 0.5) > 0.4}
    assert {1, 3, 5, 6, 7, 12} <= orders
    figure(
        "torque ripple: RMS of the third octaves over RMS",
        (sum(b["rms"] ** 2 for b in channel["third_octaves"]) + channel["below_rms"] ** 2) ** 0.5 / channel["rms"],
        least=0.9,
        most=1.1,
    )


def test_the_resolution_of_the_export_is_seen(channel):
    """The export is rounded to a hundredth of a turn a minute."""
    assert channel["noise"]["resolution"] == pytest.approx(0.01 * 2.0 * 3.141592653589793 / 60.0, rel=1e-3)
