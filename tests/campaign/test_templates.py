"""New files, refused until they are filled in. Truth: what is read of them once they are."""

import re
import tomllib

import pytest

from mechid.campaign import RecordDraft, campaign_text, load_campaign, load_mechanism, new_campaign
from mechid.campaign.channel_entry import QUANTITIES
from mechid.campaign.record_entry import KEYS
from mechid.campaign.unfinished_template import EXAMPLE_COMMAND
from mechid.command.stepping import KEYS as COMMAND_KEYS
from mechid.errors import InputFileError, UsageError
from mechid.plant.drive import measured_quantities
from mechid.plant.mechanisms import ASSEMBLIES
from mechid.records import Role


@pytest.fixture
def bench(folder, monkeypatch):
    """Return a new campaign for the folder's records, asked for from the folder itself."""
    monkeypatch.chdir(folder)
    return new_campaign("a/bench", ["full_46.csv", "sweep.csv"])


@pytest.fixture
def filled(bench):
    """Return the new files filled in: the example's numbers are right, and how the records were driven is said."""
    mechanism, campaign = bench
    mechanism.write_text(re.sub(r"template = true.*\n", "", mechanism.read_text()))
    campaign.write_text(campaign.read_text().replace("command = {}", f"command = {EXAMPLE_COMMAND}"))
    return bench


def refusal(path):
    """Return the one line with which a campaign is refused."""
    with pytest.raises(InputFileError) as refused:
        load_campaign(path)
    return str(refused.value)


def test_files_in_which_nothing_is_filled_in_are_refused_with_all_that_is_left(bench):
    """Truth: nobody has written a command, nor a number."""
    line = refusal(bench[1])
    assert line.startswith("campaign.toml: record[0].command, record[1].command: empty, as mechid new wrote it; write")
    assert "mechanism.toml: template: nothing is filled in" in line
    assert line.endswith("delete this line")


def test_what_is_left_of_a_mechanism_is_named_number_by_number(bench):
    """Truth: three of its 22 numbers are changed here, a bound is one of them."""
    mechanism, campaign = bench
    campaign.write_text(campaign.read_text().replace("command = {}", f"command = {EXAMPLE_COMMAND}"))
    content = mechanism.read_text()
    for old, new in (("ratio = 50", "ratio = -80"), ("value = 9.5,", "value = 8.1,"), ("max = 5000.0", "max = 6e3")):
        content = content.replace(old, new, 1)
    mechanism.write_text(content)
    line = refusal(campaign)
    left = line.partition("wrote them: ")[2].partition(";")[0].split(", ")
    assert len(left) == 22 - 3
    assert not {"gear.ratio", "stepper.coil_resistance", "gear.stiffness"} & set(left)
    assert {"gear.damping", "stepper.detent.1.phase_deg", "housing.frequency"} <= set(left)


def test_a_record_that_is_left_is_named_alone(bench):
    campaign = bench[1]
    campaign.write_text(campaign.read_text().replace("command = {}", f"command = {EXAMPLE_COMMAND}", 1))
    assert refusal(campaign).startswith("campaign.toml: record[1].command: empty")


def test_a_mechanism_all_filled_in_is_told_to_lose_its_mark(bench):
    """Truth: no number of the example is in it."""
    text = re.sub(
        r"(?<==) ?(-?\d[\d.e-]*)(?=[ ,])", lambda m: f" {1.01 * float(m[1]) + 0.001:.6g}", bench[0].read_text()
    )
    bench[0].write_text(text)
    with pytest.raises(InputFileError, match="template: no number is the example's any more; delete this line"):
        load_mechanism(bench[0])


def test_the_mark_is_true_or_false(filled):
    path, content = filled[0], filled[0].read_text()
    path.write_text(f"template = false\n{content}")
    assert load_mechanism(path).value("gear.ratio") == 50.0
    path.write_text(f'template = "no"\n{content}')
    with pytest.raises(InputFileError, match='template: found "no"; write true or false'):
        load_mechanism(path)


def test_the_files_are_written(bench):
    assert [path.as_posix() for path in bench] == ["a/bench/mechanism.toml", "a/bench/campaign.toml"]


def test_new_files_name_the_records(tmp_path):
    written = new_campaign(tmp_path / "mine", ["one.csv"], "brushed_dc_drive")
    assert [path.name for path in written] == ["mechanism.toml", "campaign.toml"]
    assert 'name = "one"' in written[1].read_text()


def test_they_load_when_they_are_filled_in(filled):
    campaign = load_campaign(filled[1])
    assert [record.name for record in campaign.records] == ["full_46", "sweep"]
    assert [record.spec.path for record in campaign.records] == ["../../full_46.csv", "../../sweep.csv"]
    assert campaign.warnings == ()
    assert len(campaign.mechanism.free) == 15


def test_the_mechanism_is_the_papers_catalogue(filled, campaign_folder):
    """Truth: the start of the independent campaign, which is the paper's column of nominal values."""
    ours, theirs = load_mechanism(filled[0]), load_mechanism(campaign_folder / "noisy" / "mechanism.toml")
    assert dict(ours.parameters) == dict(theirs.parameters)


def test_every_key_is_explained(bench):
    content = bench[1].read_text()
    for key in (*KEYS, *COMMAND_KEYS, *QUANTITIES):
        assert key in content


def test_the_stage_that_the_comment_shows_is_one(filled):
    content = filled[1].read_text()
    stage = content[content.index("# [[stage]]") :]
    filled[1].write_text(content + stage.replace("# ", "", 1).replace("\n# ", "\n"))
    assert load_campaign(filled[1]).stages[0].records == ("full_46",)


def test_without_files_the_record_is_an_example(tmp_path):
    new_campaign(tmp_path)
    content = (tmp_path / "campaign.toml").read_text()
    assert '# [[record]]\n# name = "full_46"\n' in content
    with pytest.raises(InputFileError, match=r"^campaign\.toml: no record; write one"):
        load_campaign(tmp_path)


def test_the_example_is_a_record(tmp_path):
    mechanism, path = new_campaign(tmp_path)
    mechanism.write_text(re.sub(r"template = true.*\n", "", mechanism.read_text()))
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
    written = tomllib.loads(new_campaign(tmp_path, [tmp_path / file for file in files])[1].read_text())
    assert [record["name"] for record in written["record"]] == names
    assert [record["file"] for record in written["record"]] == files


def test_the_column_that_is_called_a_torque_is_named(tmp_path, monkeypatch):
    """And none where it stands in its place, where no column is called so, and where the file is not there yet."""
    monkeypatch.chdir(tmp_path)
    heads = {"third": "t,Trigger,Torque_Mz", "second": "t,Torque_Mz,Trigger", "unnamed": "t,a,b"}
    for name, head in heads.items():
        (tmp_path / f"{name}.csv").write_text(f"{head}\n0.0,1.0,2.0\n0.1,1.0,3.0\n")
    new_campaign("bench", ["third.csv", "second.csv", "unnamed.csv", "later.csv"])
    records = tomllib.loads((tmp_path / "bench" / "campaign.toml").read_text())["record"]
    assert [one.get("channels") for one in records] == [[{"quantity": "torque", "column": "Torque_Mz"}], *3 * [None]]


@pytest.mark.parametrize("name", ["mechanism.toml", "campaign.toml"])
def test_nothing_is_overwritten(name, tmp_path):
    (tmp_path / name).write_text("mine")
    message = f"{tmp_path / name}: already exists; give another folder, or move it away"
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
        RecordDraft(name="sweep", file="sweep.csv", use="validate", command=EXAMPLE_COMMAND),
    ]
    (folder / "campaign.toml").write_text(campaign_text(drafts, "synthetic"))
    campaign = load_campaign(folder)
    assert [record.use for record in campaign.records] == ["estimate", "validate"]
    assert campaign.record("full_46").command.steps_per_full_step == 2
    assert (folder / "campaign.toml").read_text().startswith("# synthetic\n\nmechanism = ")


@pytest.mark.parametrize("assembly", ASSEMBLIES)
def test_each_assembly_has_files_to_start_from(assembly, tmp_path):
    """Truth: the assembly's own name and inputs: what is written is read once nothing is left to fill in."""
    (tmp_path / "run.csv").write_text("time_s,torque_Nm\n0,0\n")
    mechanism, campaign = new_campaign(tmp_path / "bench", [tmp_path / "run.csv"], assembly)
    line = refusal(campaign)
    assert "empty, as mechid new wrote it" in line
    assert "mechanism.toml: template: nothing is filled in" in line
    mechanism.write_text(re.sub(r"template = true.*\n", "", mechanism.read_text()))
    assert load_mechanism(mechanism).plant.name == assembly
    text = campaign.read_text().replace("command = {}", f"command = {EXAMPLE_COMMAND}")
    campaign.write_text(re.sub(r"channels = \[\]  # write which column is what, as (.*)", r"channels = \1", text))
    (record,) = load_campaign(campaign, read_records=False).records
    inputs = {c.quantity for c in record.spec.channels if c.role is Role.INPUT}
    assert inputs == set(measured_quantities(load_mechanism(mechanism).plant.inputs))


def test_an_unknown_assembly_is_answered_with_the_nearest(tmp_path):
    with pytest.raises(UsageError, match=r'assembly: unknown "brushed_dc"; did you mean "brushed_dc_drive"\?'):
        new_campaign(tmp_path, (), "brushed_dc")
    assert not list(tmp_path.iterdir())
