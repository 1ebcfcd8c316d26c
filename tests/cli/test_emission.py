"""`mechid emission`. Truth: a line of 0.05 N that was written into the record."""

import sys

import pytest

from emission_bench import background, record, requirement, samples, write_campaign


def judge(run, folder, limit, *options):
    runs = {"run": samples(1, ((46.0, 0.05),)), "off": samples(2)}
    write_campaign(folder, runs, record("run", 46.0), background())
    (folder / "s.toml").write_text(requirement(mask=((20.0, limit), (500.0, limit))))
    return run("emission", folder, "--requirements", folder / "s.toml", "--out", folder / "out", *options)


@pytest.mark.parametrize(
    ("limit", "options", "code"), [(0.1, ("--strict",), 0), (0.01, (), 0), (0.01, ("--strict",), 5)]
)
def test_only_a_strict_command_fails_with_a_verdict(run, tmp_path, limit, options, code):
    result = judge(run, tmp_path, limit, *options)
    assert result.exit_code == code
    assert (tmp_path / "out" / "emission.html").is_file()


def test_an_option_that_is_not_there_is_refused(run, tmp_path):
    assert judge(run, tmp_path, 0.1, "--pdf").exit_code == 2


def test_the_test_report_is_written_when_asked_for(run, tmp_path):
    assert "emission.docx" not in judge(run, tmp_path, 0.1).stdout
    assert f"written: {tmp_path / 'out' / 'emission.docx'}" in judge(run, tmp_path, 0.1, "--docx").stdout


@pytest.mark.parametrize("command", ["emission", "identify", "budget", "report"])
def test_without_python_docx_the_test_report_is_refused_before_any_work(run, tmp_path, monkeypatch, command):
    """Truth: the file to be read is not there, which would be refused with 3."""
    monkeypatch.setitem(sys.modules, "docx", None)
    place = [tmp_path / "none.toml"] if command == "report" else [tmp_path / "none.toml", "--out", tmp_path / "out"]
    result = run(command, *place, "--docx")
    assert result.exit_code == 2
    assert 'docx: a Word document needs python-docx; pip install "mechid[office]"' in result.stderr
    assert not (tmp_path / "out").exists()


def test_a_campaign_without_requirements_says_what_to_write(run, tmp_path):
    write_campaign(tmp_path, {"run": samples(1)}, record("run", 46.0))
    result = run("emission", tmp_path, "--out", tmp_path / "out")
    assert result.exit_code == 3
    assert "campaign.toml: no requirement; write one [[requirement]] table for each" in result.stderr
