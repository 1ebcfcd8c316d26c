"""Results as text, as HTML and drawn. Truth: the numbers that the results hold."""

import numpy as np
import pytest
from matplotlib import pyplot

import mechid
from mechid.display import DOCUMENTS, DisplayedResult, presenter_of
from mechid.ink.presenter import Presenter


@pytest.fixture
def run():
    record = mechid.make_record("a", command=mechid.make_command("full", rate=46.0, start_angle_deg=45.0))
    return mechid.simulate(mechid.make_campaign(mechid.catalogue_mechanism(), [record]), duration_s=0.1)


def test_a_result_is_a_line_a_text_and_a_notebooks_table(run):
    assert repr(run) == "<Trajectory: torque: 1001 samples, complete>"
    rms = float(np.sqrt(np.mean(run.torque**2)))
    assert f"{rms:.4f}" in str(run)
    assert f"{rms:.4f}" in run._repr_html_()
    assert run._repr_html_().startswith("<pre")
    assert run.to_dict()["records"][0]["rms"] == pytest.approx(rms)


def test_a_result_leaves_its_files(run, tmp_path):
    path, *_ = run.write(tmp_path / "made" / "here")
    assert np.loadtxt(path, delimiter=",", skiprows=1)[:, 1] == pytest.approx(run.torque, abs=1e-12)


def test_values_are_short_lines():
    mechanism = mechid.catalogue_mechanism()
    record = mechid.make_record(
        "a", np.arange(100.0), sample_rate_hz=1e3, command=mechid.make_command("full", rate=1.0)
    )
    campaign = mechid.make_campaign(mechanism, [record])
    assert repr(mechanism) == f"<Mechanism stepper_gear_mass: {len(mechanism.parameters)} parameters, 15 free>"
    assert repr(campaign.records[0].data) == "<Record a: torque; 100 samples at 1000 Hz>"
    assert "15 free parameters, records a" in repr(campaign)
    assert "<td>gear.stiffness</td><td>2200</td><td>N m/rad</td>" in mechanism._repr_html_()


def test_axes_in_are_axes_out(run):
    axes = pyplot.figure().subplots()
    assert run.plot(ax=axes) is axes
    drawn = axes.lines[0].get_ydata()
    assert (drawn.min(), drawn.max()) == (run.torque.min(), run.torque.max())  # the extremes are kept
    assert axes.get_ylabel() == "torque, N m"
    assert run.plot().get_xlabel() == "time, s"
    with pytest.raises(mechid.UsageError, match='no quantity "torqe"; did you mean "torque"'):
        run.plot("torqe")
    pyplot.close("all")


def test_a_fit_without_its_campaign_says_what_to_give(tmp_path):
    with pytest.raises(mechid.UsageError, match="is no folder"):
        mechid.load_fit(
            tmp_path / "none",
            mechid.make_campaign(
                mechid.catalogue_mechanism(), [mechid.make_record("a", command=mechid.make_command("full", rate=1.0))]
            ),
        )


def test_each_kind_of_result_has_a_presenter():
    """Truth: the public classes that show themselves."""
    public = [value for name in mechid.__all__ if isinstance(value := getattr(mechid, name), type)]
    assert {value.__name__ for value in public if issubclass(value, DisplayedResult)} <= DOCUMENTS.keys()
    for kind in DOCUMENTS:
        assert isinstance(presenter_of(type(kind, (), {})()), Presenter), kind
