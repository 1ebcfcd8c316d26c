"""What a fit hands on. Truth: the files beside its estimate."""

import json
from dataclasses import replace


def test_synthetic_records_are_called_so(paper, tmp_path):
    """Truth: the report beside the estimate, of the same fit; another fit's report says nothing."""
    assert "SYNTHETIC" not in paper.trust
    report = {"synthetic": True, "provenance": paper.fit.provenance}
    (tmp_path / "report.json").write_text(json.dumps(report), encoding="utf-8")
    elsewhere = replace(paper.fit, folder=tmp_path)
    assert replace(paper, fit=elsewhere).provenance["trust"].startswith("SYNTHETIC: the records were simulated")
    (tmp_path / "report.json").write_text(json.dumps(report | {"provenance": {}}), encoding="utf-8")
    assert "SYNTHETIC" not in replace(paper, fit=elsewhere).trust
