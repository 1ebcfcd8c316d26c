"""What a campaign file declares of its test. Truth: the tables as written, and the digests of the files they name."""

import hashlib
import tomllib
from datetime import date

import pytest

import mechid
from mechid.campaign.declared_test import DeclaredTest, read_declared_test
from mechid.campaign.place import Place
from mechid.errors import InputFileError

TEXT = """
[article]
serial_number = "EM-3"
name = "SADM-200"

[test]
reference = "TR-42"
date = 2026-04-02
set_up = "Clamped to the table."
deviations = ["No run at 90 steps/s."]

[[instrument]]
name = "9255C"
calibrated = 2025-03-01
calibration_due = 2026-03-01
certificate = "k.pdf"

[bench]
drive_axis = "z"
mounting_point_m = [0.0, 0.0, 0.05]
"""


def read(text, folder):
    return read_declared_test(tomllib.loads(text), Place("campaign.toml"), folder)


def test_the_tables_are_kept_in_the_order_of_the_report(tmp_path):
    (tmp_path / "k.pdf").write_bytes(b"certificate")
    found = read(TEXT, tmp_path).to_dict()
    assert found == {
        "article": {"name": "SADM-200", "serial_number": "EM-3"},
        "test": {"reference": "TR-42", "date": "2026-04-02", "set_up": "Clamped to the table."},
        "deviations": ["No run at 90 steps/s."],
        "instruments": [
            {"name": "9255C", "calibrated": "2025-03-01", "calibration_due": "2026-03-01", "certificate": "k.pdf"}
        ],
        "bench": {"drive_axis": "z", "mounting_point_m": [0.0, 0.0, 0.05]},
        "files": {"k.pdf": hashlib.sha256(b"certificate").hexdigest()},
    }
    assert list(found["article"]) == ["name", "serial_number"]


def test_a_campaign_need_not_say_anything(tmp_path):
    assert read("", tmp_path) == DeclaredTest()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('article = "SADM"', r'campaign.toml: article: found "SADM"; write a table under \[article\]'),
        ('[article]\nnam = "x"', r"article.nam: unknown key; did you mean"),
        ('[article]\nmodel = "EM"', r'article.name: missing; write a text, as "SADM-200"'),
        ('[article]\nname = ""', r"article.name: found"),
        ("[article]\nname = 3", r"article.name: found 3; write a text"),
        ('[test]\ndate = "2 April"', r"test.date: found .*2 April.*; write a date, as 2026-03-31"),
        ("[test]\ndate = 2026-04-02T10:00:00", r"test.date: found .*; write a date"),
        ('[test]\ndate = "2026-02-30"', r"test.date: found .*2026-02-30"),
        ('[test]\ndeviations = "none"', r'test.deviations: found "none"; write \["..."\]'),
        ("[[instrument]]\n", r"instrument\[0\].name: missing"),
        ('[[instrument]]\nmeasures = "fx"', r"instrument\[0\].name: missing"),
        (
            '[[instrument]]\nname = "a"\ncalibrated = 2026-01-02\ncalibration_due = 2025-01-02',
            r"instrument\[0\].calibration_due: 2025-01-02 is before calibrated, 2026-01-02",
        ),
        ('[instrument]\nname = "a"', r"write each as a table under \[\[instrument\]\]"),
    ],
)
def test_a_wrong_entry_is_answered_with_its_place(tmp_path, text, message):
    with pytest.raises(InputFileError, match=message):
        read(text, tmp_path)


def test_a_campaign_in_code_declares_the_same_and_is_written_with_it(tmp_path):
    """Truth: the campaign that is read back from the files."""
    record = mechid.make_record("a", command=mechid.make_command("full", rate=46.0))
    entries = {
        "article": {"name": "SADM-200"},
        "instrument": [{"name": "9255C", "calibrated": date(2025, 3, 1)}],
        "test": {"date": "2026-04-02"},
    }
    made = mechid.make_campaign(mechid.catalogue_mechanism(), [record], entries=entries)
    assert made.test.instruments == ({"name": "9255C", "calibrated": "2025-03-01"},)
    mechid.write_campaign(made, tmp_path / "out")
    text = (tmp_path / "out" / "campaign.toml").read_text(encoding="utf-8")
    assert read(text, tmp_path).to_dict() == made.test.to_dict()
