"""A test designed without files. Truth: the mechanism that it was designed for, read back from what it leaves."""

import pytest

import mechid
from mechid.designs.design_file import CandidateChoice

STIFFNESS = "gear.stiffness"


@pytest.mark.slow
def test_a_proposal_of_a_campaign_in_memory_brings_its_mechanism(tmp_path):
    mechanism = mechid.catalogue_mechanism().with_values({STIFFNESS: 1234.5}).with_free((STIFFNESS,))
    planned = mechid.make_record("full_46", command=mechid.make_command("full", rate=46.0))
    campaign = mechid.make_campaign(mechanism, [planned])
    choice = CandidateChoice(steppings=("full",), rates=(40.0, 50.0), start_angles_deg=(0.0,), sweeps_s=())
    options = mechid.DesignOptions(mechanisms=1, candidates=choice)
    mechid.design(campaign, options, total_s=15.0).write(tmp_path / "next")
    proposed = mechid.load_campaign(tmp_path / "next", read_records=False)
    assert proposed.mechanism_path.resolve() == (tmp_path / "next" / "mechanism.toml").resolve()
    assert proposed.mechanism.value(STIFFNESS) == 1234.5
    assert [parameter.name for parameter in proposed.mechanism.free] == [STIFFNESS]
