"""New files: they load as they are, and explain themselves."""

import re

import pytest

from mechid.campaign import RecordDraft, campaign_text, load_campaign, new_campaign, read_mechanism
from mechid.campaign.channel_entry import QUANTITIES
from mechid.campaign.record_entry import KEYS
from mechid.command.stepping import KEYS as COMMAND_KEYS
from mechid.errors import InputFileError, UsageError


@pytest.fixture
def bench(folder, monkeypatch):
    """Return a new campaign for the folder's records, asked for from the folder itself."""
    monkeypatch.chdir(folder)
    return new_campaign("a/bench", ["full_46.csv", "sweep.csv"])


def test_the_files_are_written(bench):
    assert [path.as_posix() for path in bench] == ["a/bench/mechanism.toml", "a/bench/campaign.toml"]


def test_they_load_as_they_are(bench):
    campaign = load_campaign(bench[1])
    assert [record.name for record in campaign.records] == ["full_46", "sweep"]
    assert [record.spec.path for record in campaign.records] == ["../../full_46.csv", "../../sweep.csv"]
    assert campaign.warnings == ()
    assert len(campaign.mechanism.free) == 15


def test_the_mechanism_is_the_papers_catalogue(bench, campaign_folder):
    """Truth: the start of the independent campaign, which is the paper's column of nominal values."""
    ours, theirs = read_mechanism(bench[0]), read_mechanism(campaign_folder / "noisy" / "mechanism.toml")
    assert dict(ours.parameters) == dict(theirs.parameters)


def test_every_key_is_explained(bench):
    content = bench[1].read_text()
    for key in (*KEYS, *COMMAND_KEYS, *QUANTITIES):
        assert key in content


def test_the_stage_that_the_comment_shows_is_one(bench):
    content = bench[1].read_text()
    stage = content[content.index("# [[stage]]") :]
    bench[1].write_text(content + stage.replace("# ", "", 1).replace("\n# ", "\n"))
    assert load_campaign(bench[1]).stages[0].records == ("full_46",)


def test_without_files_the_record_is_an_example(tmp_path):
    new_campaign(tmp_path)
    content = (tmp_path / "campaign.toml").read_text()
    assert '# [[record]]\n# name = "full_46"\n' in content
    with pytest.raises(InputFileError, match=r"^campaign\.toml: no record; write one"):
        load_campaign(tmp_path)


def test_the_example_is_a_record(tmp_path):
    new_campaign(tmp_path)
    path = tmp_path / "campaign.toml"
    content = path.read_text()
    start = content.index("# [[record]]")
    path.write_text(content[:start] + content[start:].split("\n\n")[0].replace("# ", ""))
    assert load_campaign(path, read_records=False).records[0].name == "full_46"


@pytest.mark.parametrize(
    ("files", "names"),
    [
        (["run 1.csv"], ["run_1"]),
        (["Prüfung.csv"], ["Prufung"]),
        (["°.csv"], ["record"]),
        (["a/run.csv", "b/Run.csv", "b/run.txt"], ["run", "Run_2", "run_3"]),
        (["run_2.csv", "x/run.csv", "y/run.csv"], ["run_2", "run", "run_3"]),
    ],
)
def test_names_of_records(files, names, tmp_path):
    new_campaign(tmp_path, [tmp_path / file for file in files])
    campaign = load_campaign(tmp_path, read_records=False)
    assert [record.name for record in campaign.records] == names
    assert [record.spec.path for record in campaign.records] == files


@pytest.mark.parametrize("name", ["mechanism.toml", "campaign.toml"])
def test_nothing_is_overwritten(name, tmp_path):
    (tmp_path / name).write_text("mine")
    message = f"{tmp_path / name}: is there already; give another folder, or move it away"
    with pytest.raises(UsageError, match=f"^{re.escape(message)}$"):
        new_campaign(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_text() == "mine"


def test_a_file_is_no_folder(tmp_path):
    (tmp_path / "bench").write_text("")
    with pytest.raises(UsageError, match=r"bench: cannot be written to \(.+\); give another folder$"):
        new_campaign(tmp_path / "bench")


def test_a_campaign_of_drafts(folder):
    """Truth: what is written is what is read."""
    drafts = [
        RecordDraft(name="full_46", file="full_46.csv", command='{ stepping = "half", rate = 23.0 }'),
        RecordDraft(name="sweep", file="sweep.csv", use="validate"),
    ]
    (folder / "campaign.toml").write_text(campaign_text(drafts, "synthetic"))
    campaign = load_campaign(folder)
    assert [record.use for record in campaign.records] == ["estimate", "validate"]
    assert campaign.record("full_46").command.steps_per_full_step == 2
    assert (folder / "campaign.toml").read_text().startswith("# synthetic\n\nmechanism = ")
