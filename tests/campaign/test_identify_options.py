"""The [identify] table: what it says, and what a wrong entry is answered. Truth: the file as written."""

import pytest

from mechid.campaign import load_campaign
from mechid.campaign.identify_options import IdentifyOptions
from mechid.errors import InputFileError

FIRST = 'mechanism = "mechanism.toml"\n'


def with_table(changed, table):
    return changed("campaign.toml", FIRST, f"{FIRST}\n[identify]\n{table}\n")


def test_without_the_table_the_defaults_hold(folder):
    assert load_campaign(folder / "campaign.toml").options == IdentifyOptions()


def test_every_key_is_read(changed):
    table = """
priors = "search"
colour = "prefilter"
spikes = "reject"
freeze = false
max_relative_error = 0.2
max_correlation = 0.95"""
    wanted = IdentifyOptions(
        priors="search", colour="prefilter", spikes="reject", freeze=False, max_relative_error=0.2, max_correlation=0.95
    )
    assert load_campaign(with_table(changed, table)).options == wanted


@pytest.mark.parametrize(
    ("entry", "answer"),
    [
        ('priors = "serach"', ["identify.priors", "serach", '"search"']),
        ('colour = "prefliter"', ["identify.colour", "prefliter", '"prefilter"']),
        ("spikes = true", ["identify.spikes", "true", '"reject"']),
        ('freeze = "no"', ["identify.freeze", "no", "write true or false"]),
        ("freeze = 0", ["identify.freeze", "0", "write true or false"]),
        ('max_relative_error = "5 %"', ["identify.max_relative_error", "5 %", "number"]),
        ("max_relative_error = -0.1", ["identify.max_relative_error", "-0.1", "above 0"]),
        ("max_correlation = true", ["identify.max_correlation", "true", "number"]),
        ('terms = "yes"', ["identify.terms", "yes", "write true or false"]),
        ('disturbances = "clok"', ["identify.disturbances", "clok", '"auto", "none", or a list', '"clock"']),
        ('disturbances = ["clok"]', ["identify.disturbances[0]", "clok", 'did you mean "clock"']),
        ("disturbances = 5", ["identify.disturbances", "5", '"auto", "none", or a list']),
        ('mains = "55"', ["identify.mains", "55", "without quotes"]),
        ("mains = 55", ["identify.mains", "55", "50 or 60"]),
        ("max_corelation = 0.9", ["identify.max_corelation", "unknown key", "max_correlation"]),
    ],
)
def test_a_wrong_entry_is_answered_with_place_and_remedy(changed, entry, answer):
    with pytest.raises(InputFileError) as error:
        load_campaign(with_table(changed, entry))
    assert all(part in str(error.value) for part in answer), str(error.value)
