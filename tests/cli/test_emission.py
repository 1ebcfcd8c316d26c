"""`mechid emission`. Truth: a line of 0.05 N that was written into the record."""

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
    assert judge(run, tmp_path, 0.1, "--docx").exit_code == 2


def test_a_campaign_without_requirements_says_what_to_write(run, tmp_path):
    write_campaign(tmp_path, {"run": samples(1)}, record("run", 46.0))
    result = run("emission", tmp_path, "--out", tmp_path / "out")
    assert result.exit_code == 3
    assert "campaign.toml: no requirement; write one [[requirement]] table for each" in result.stderr
