"""The report of several channels. Truth: fits without one of them, and the words of its quantity."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from browser import chromium, faults, shown
from channels import FREE, written
from layouts import changed, mechanism_of, paper_table
from mechid.analysis import validate
from mechid.identification.identify import identify
from mechid.identification.result.estimate_file import write_estimate
from mechid.identification.result.fit_file import read_fit
from mechid.reports.contents import report_contents
from mechid.reports.document import PRESENTER
from mechid.reports.files import write_report
from mechid.reports.numbers import report_data
from printing import printed

QUANTITIES = ("torque", "output_angle", "current_phase_a")


@pytest.fixture(scope="module")
def joint(tmp_path_factory):
    """Return a campaign of torque, angle and current, its fit, and what its report shows."""
    table = changed(paper_table(), {"stepper": {"back_emf_constant": None}})  # tied, or a current alone tells R
    m, folder = mechanism_of(table), tmp_path_factory.mktemp("joint")
    campaign = written(folder, m, {name: m.value(name) for name in FREE}, quantities=QUANTITIES)
    fit = identify(campaign)
    validation = validate(campaign, fit)
    data = report_data(fit, validation=validation)
    return SimpleNamespace(campaign=campaign, fit=fit, validation=validation, data=data, folder=folder)


@pytest.mark.parametrize("dropped", QUANTITIES)
def test_what_a_channel_adds_is_the_growth_of_the_errors_without_it(joint, dropped):
    """Truth: the white standard errors of the fit of the other channels."""
    information = report_contents(joint.data, joint.campaign, joint.fit)["information"]
    assert information["channels"] == list(QUANTITIES)
    records = tuple(
        replace(r, matches=tuple(m for m in r.matches if m.quantity != dropped)) for r in joint.campaign.records
    )
    without = identify(replace(joint.campaign, mechanism=joint.fit.mechanism, records=records))
    k = QUANTITIES.index(dropped)
    for name, factors, shares in zip(
        information["parameters"], information["without_channel"], information["channel_share_percent"], strict=True
    ):
        grown = without.parameters[name].std_error_white / joint.fit.parameters[name].std_error_white
        assert factors[k] == pytest.approx(grown, rel=0.1)
        assert sum(shares) == pytest.approx(100.0)


def test_terminal_and_markdown_name_each_channel_with_its_unit(joint):
    text = printed(PRESENTER.print, joint.data, 120)
    for quantity, unit in (("torque", "N m"), ("output angle", "rad"), ("current phase a", "A")):
        assert any(quantity in line and f" {unit} " in line for line in text.splitlines())
    assert "in N m" not in text


def test_a_fit_of_channels_is_read_back(joint, tmp_path):
    write_estimate(joint.fit, tmp_path / "estimate.json")
    assert read_fit(tmp_path / "estimate.json", joint.campaign).records == joint.fit.records


@pytest.mark.slow
def test_figures_of_a_channel_carry_its_own_unit(joint):
    """Also in a browser: labels and tips of the script's figures, which are made for a torque."""
    write_report(joint.data, joint.campaign, joint.fit, joint.validation, joint.folder / "out")
    page = joint.folder / "out" / "report.html"
    for name, label in (
        ("full_46_torque", "torque, N m"),
        ("full_46.output_angle", "output angle, rad"),
        ("full_46.current_phase_a_spectrum", "amplitude, A"),
    ):
        assert label in (joint.folder / "out" / "figures" / f"{name}.svg").read_text()
    assert "What each channel adds" in page.read_text()
    assert "What each channel adds" in (joint.folder / "out" / "report.md").read_text()
    with chromium() as browser:
        shown(browser, page, 1400)
        assert faults(browser) == []
        labels = browser.execute_script(
            "return [...mechid.documents].filter(([t]) => t.dataset.record === 'full_46.output_angle').map(([, d]) => "
            "[...d.root.references()].filter((m) => m.type.endsWith('Axis')).map((m) => m.axis_label)).flat()"
        )
        tips = browser.execute_script(
            "return [...mechid.documents].filter(([t]) => t.dataset.record === 'full_46.output_angle').map(([, d]) => "
            "[...d.root.references()].filter((m) => m.type === 'HoverTool').map((m) => m.tooltips)).flat(3)"
        )
    assert {"output angle, rad", "residual, rad", "amplitude, rad", "residual density, rad/√Hz"} <= set(labels)
    assert not any("N m" in text for text in (*labels, *tips))
