"""Campaign: records with their commands, the mechanism and the stages of a fit, read from files.

`load_campaign` reads a `Campaign`; `new_campaign` writes the files to start from.

Internal to mechid but for the names that docs/python.md lists.
"""

from mechid.campaign.campaign import Campaign, CampaignRecord, Match, Stage
from mechid.campaign.campaign_file import load_campaign
from mechid.campaign.catalogue import catalogue_mechanism
from mechid.campaign.mechanism_file import load_mechanism, mechanism_from_table
from mechid.campaign.mechanism_text import mechanism_text, write_mechanism
from mechid.campaign.templates import RecordDraft, campaign_text, new_campaign

__all__ = [
    "Campaign",
    "CampaignRecord",
    "Match",
    "RecordDraft",
    "Stage",
    "campaign_text",
    "catalogue_mechanism",
    "load_campaign",
    "load_mechanism",
    "mechanism_from_table",
    "mechanism_text",
    "new_campaign",
    "write_mechanism",
]
