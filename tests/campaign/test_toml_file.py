"""Kinds of TOML files. Truth: the keys that a file has, by hand."""

import pytest

from mechid.campaign.toml_file import KINDS, SHARED, read_toml
from mechid.errors import InputFileError

REQUIREMENT = '[[requirement]]\nname = "r"\n'
RECORD = '[[record]]\nname = "full_46"\n'


@pytest.fixture
def file(tmp_path):
    def write(text):
        (tmp_path / "a.toml").write_text(text, encoding="utf-8")
        return tmp_path / "a.toml"

    return write


@pytest.mark.parametrize("kind", KINDS)
def test_a_requirement_alone_tells_no_kind(file, kind):
    """It stands in campaigns and in budgets, so a file of requirements is called neither."""
    assert "requirement" in SHARED
    assert list(read_toml(file(REQUIREMENT), kind)) == ["requirement"]


def test_a_campaign_with_requirements_is_no_budget(file):
    with pytest.raises(InputFileError, match=r"a.toml: is a campaign file; give a budget file"):
        read_toml(file(REQUIREMENT + RECORD), "budget")
    assert set(read_toml(file(REQUIREMENT + RECORD), "campaign")) == {"requirement", "record"}


def test_a_budget_with_requirements_is_no_campaign(file):
    text = 'estimate = "fit"\n' + REQUIREMENT
    with pytest.raises(InputFileError, match=r"a.toml: is a budget file; give a campaign file"):
        read_toml(file(text), "campaign")
    assert set(read_toml(file(text), "budget")) == {"estimate", "requirement"}
