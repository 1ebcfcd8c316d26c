"""What a campaign joins. Truth: its files."""

import re

import pytest

from mechid.campaign import load_campaign
from mechid.errors import UsageError


def test_free_parameters_of_records_follow_those_of_the_mechanism(folder):
    campaign = load_campaign(folder)
    assert [q.name for q in campaign.free] == [*(q.name for q in campaign.mechanism.free), "record.sweep.time_offset_s"]
    assert len(campaign.parameters) == len(campaign.mechanism.parameters) + 2


def test_an_unknown_record_of_a_campaign(folder):
    message = 'campaign.toml: no record "swep"; did you mean "sweep"?'
    with pytest.raises(UsageError, match=f"^{re.escape(message)}$"):
        load_campaign(folder).record("swep")
