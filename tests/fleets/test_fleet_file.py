"""fleet.toml and folders without one. Truth: the file's own keys, and one line with place and remedy for each fault."""

from datetime import date

import pytest

from estimates import free
from mechid.errors import InputFileError, UsageError
from mechid.fleets.fleet_file import read_fleet_file, read_members
from synthetic_fleet import write_fit, write_fleet_file


@pytest.fixture
def fits(tmp_path):
    """Return a folder with the finished fits A and B."""
    for name in "AB":
        write_fit(tmp_path / name, {"gear.stiffness": free(900.0, 1.0)})
    return tmp_path


@pytest.fixture
def wrong(fits):
    """Return a function that writes a fleet file of two campaigns and returns what is said of it."""

    def say(first="", second="", head=""):
        text = f'{head}\n[[campaign]]\nfolder = "A"\n{first}\n[[campaign]]\nfolder = "B"\n{second}\n'
        (fits / "fleet.toml").write_text(text, encoding="utf-8")
        with pytest.raises(InputFileError) as caught:
            read_fleet_file(fits / "fleet.toml")
        return str(caught.value)

    return say


def test_all_keys(fits):
    entries = (
        {
            "folder": '"A"',
            "label": '"FM1, cold"',
            "unit": '"FM1"',
            "group": '"lot 1"',
            "state": '"cold"',
            "covariates": "{ temperature_degC = -20, date = 2026-03-01 }",
        },
        {"folder": '"B"', "unit": '"FM1"', "group": '"lot 1"', "state": '"hot"'},
    )
    asked = read_members(
        [write_fleet_file(fits, entries, 'before_after = [["cold", "hot"]]\nfalse_discovery_rate = 0.1')]
    )
    first, second = asked.members
    assert (first.label, first.unit, first.group, first.state) == ("FM1, cold", "FM1", "lot 1", "cold")
    assert first.covariates == {"temperature_degC": -20.0, "date": date(2026, 3, 1)}
    assert first.folder_name == "FM1_cold"
    assert (second.label, second.unit, second.covariates) == ("B", "FM1", {})
    assert (asked.before_after, asked.false_discovery_rate, asked.units) == ((("cold", "hot"),), 0.1, ("FM1",))
    assert asked.baseline == (first,)


def test_folders_alone_and_beside_a_fleet_file(fits):
    alone = read_members([fits / "A", fits / "B" / "estimate.json"])
    assert [(m.label, m.unit, m.source) for m in alone.members] == [(n, n, fits / n) for n in "AB"]
    write_fleet_file(fits, [{"folder": '"A"', "label": '"first"'}])
    assert [m.label for m in read_members([fits, fits / "A", fits / "B"]).members] == ["first", "B"]


@pytest.mark.parametrize(
    ("first", "second", "head", "said"),
    [
        ("lable = 'x'", "", "", 'fleet.toml: campaign[0].lable: unknown key; did you mean "label"?'),
        ("label = 3", "", "", "fleet.toml: campaign[0].label: found 3; write label ="),
        ("label = 'B'", "", "", 'fleet.toml: campaign[1].label: "B" stands here twice'),
        ("covariates = 20", "", "", "fleet.toml: campaign[0].covariates: found 20; write a table"),
        ("covariates = { T = 'warm' }", "", "", 'fleet.toml: campaign[0].covariates.T: found "warm"; write the number'),
        ("covariates = { T = 1.0 }", "covariates = { T = 2026-01-01 }", "", "campaign[1].covariates.T: is a date here"),
        ("unit = 'u'\ngroup = 'a'", "unit = 'u'\ngroup = 'b'", "", 'campaign[1].group: found "b", and "a" in another'),
        ("", "", "before_after = [['cold', 'hot']]", 'before_after[0]: no campaign has state = "cold"'),
        ("state = 'cold'", "", "before_after = [['cold']]", "before_after[0]: found 1 states; write pairs"),
        ("state = 's'\nunit = 'u'", "state = 's'\nunit = 'u'", "before_after = [['s', 'r']]", 'unit "u" has several'),
        ("", "", "false_discovery_rate = 5", "false_discovery_rate: found 5; write a share between 0 and 1"),
        ("", "", "mechanism = 'm.toml'", "fleet.toml: mechanism: unknown key"),
    ],
)
def test_what_is_wrong_is_said_with_its_place(wrong, first, second, head, said):
    assert said in wrong(first, second, head)


def test_folders_that_are_none(fits):
    write_fleet_file(fits, [{"folder": '"C"'}])
    with pytest.raises(InputFileError, match=r"campaign\[0\].folder: .*C: there is no such folder"):
        read_members([fits])
    with pytest.raises(InputFileError, match="there is no such folder or file"):
        read_members([fits / "elsewhere"])
    (fits / "empty").mkdir()
    with pytest.raises(InputFileError, match=r"holds neither campaign.toml nor estimate.json"):
        read_members([fits / "empty"])
    with pytest.raises(UsageError, match="nothing is given"):
        read_members([])


def test_two_fleet_files_are_refused(fits):
    other = fits / "other"
    other.mkdir()
    for folder in (fits, other):
        write_fleet_file(folder, [{"folder": '"A"'}])
    with pytest.raises(UsageError, match="found 2 fleet files"):
        read_members([fits, other])


def test_labels_that_would_share_a_folder_are_refused(fits):
    write_fleet_file(fits, [{"folder": '"A"', "label": '"FM 1"'}, {"folder": '"B"', "label": '"fm?1"'}])
    with pytest.raises(InputFileError, match="give the same folder of results"):
        read_members([fits])
