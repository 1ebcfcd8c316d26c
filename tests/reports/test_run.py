"""The report written by a function. Truth: the files of the folder, and the fit that they hold."""

import mechid
from mechid.identification.result.fit_file import read_fit


def test_a_report_made_anew_leaves_the_results_as_they_are(reported, tmp_path):
    files = mechid.report(reported.fit, tmp_path, campaign=reported.campaign, truth={"gear.stiffness": 900.0})
    results = ("estimate.json", "mechanism.toml", "report.json", "residual.json")
    assert {path.name for path in files} == {*results, "report.html", "report.md", "figures"}
    signed = {name: (tmp_path / name).read_bytes() for name in ("estimate.json", "mechanism.toml")}
    fit = read_fit(tmp_path / "estimate.json", reported.campaign)
    again = mechid.report(fit, tmp_path, campaign=reported.campaign)
    assert {path.name for path in again} == {"report.html", "report.json", "report.md", "residual.json", "figures"}
    assert {name: (tmp_path / name).read_bytes() for name in signed} == signed
    assert '"truth": 900.0' in (tmp_path / "report.json").read_text(encoding="utf-8")
