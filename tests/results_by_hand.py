"""Results of mechid as small files written by hand, for the index of all results."""

import hashlib
import json

SVG = '<svg xmlns="http://www.w3.org/2000/svg" width="9" height="4"></svg>'
CAMPAIGN = 'mechanism = "mechanism.toml"\n[[record]]\nname = "a"\nfile = "data/a.csv"\ncommand = {stepping = "full"}\n'
PAGES = {"estimate.json": "report.html", "budget.json": "budget.html"}


def write(file, content):
    """Write a file, its folder made, and return its digest."""
    file.parent.mkdir(parents=True, exist_ok=True)
    text = content if isinstance(content, str) else json.dumps(content)
    file.write_text(text, encoding="utf-8")
    return hashlib.sha256(text.encode()).hexdigest()


def write_campaign(folder):
    """Write a campaign of one record, and return the digests of its files."""
    return {
        "campaign.toml": write(folder / "campaign.toml", CAMPAIGN),
        "mechanism.toml": write(folder / "mechanism.toml", "[gear]\nratio = 50\n"),
        "a.csv": write(folder / "data" / "a.csv", "time_s,torque_Nm\n0,0\n"),
    }


def write_fit(folder, campaign=None, grade="B", inputs=None):
    """Write a fit of a campaign with a page and a figure, and return the digest of its mechanism."""
    digest = write(folder / "mechanism.toml", f"[gear]\nratio = 50 # {folder.name!a}\n")
    provenance = {"inputs_sha256": inputs or {}, "mechanism_file": "mechanism.toml", "mechanism_sha256": digest}
    reasons = [{"text": "Record a is not followed.", "next_command": "mechid diagnose"}]
    content = {"format": "mechid-estimate/1", "synthetic": True, "grade": grade, "grade_reasons": reasons}
    write(folder / "estimate.json", {**content, "provenance": provenance})
    write(folder / "report.html", "<title>a fit</title>")
    write(folder / "figures" / "a_torque.svg", SVG)
    if campaign is not None:
        write(folder / "journal.jsonl", json.dumps({"event": "started", "campaign": str(campaign)}) + "\n")
    return digest


def write_budget(folder, digest, margin=0.25):
    """Write a budget of a fit with one requirement."""
    one = {"requirement": "stability", "mode": "scan", "axis": "x"}
    decided = {"margin": margin, "met": margin > 0.0}
    content = {"format": "mechid-budget/1", "requirements": [{**one, "decided": decided}], "warnings": []}
    write(folder / "budget.json", {**content, "provenance": {"fit": {"mechanism_sha256": digest}}})
    write(folder / "budget.html", "<title>a budget</title>")
