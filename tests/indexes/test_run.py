"""The index of all results below a folder. Truth: files written by hand, and what was damaged or changed of them."""

import os
import time
from pathlib import Path

import pytest

import mechid
from mechid.errors import UsageError
from mechid.indexes.run import index_of
from results_by_hand import write, write_budget, write_campaign, write_fit

FILES, SECONDS = 10_000, 5.0
FIT = str(Path("FM1") / "fit")


@pytest.fixture
def bench(tmp_path):
    """Return a folder with a campaign, a fit of it and a budget of that."""
    inputs = write_campaign(tmp_path / "FM1")
    digest = write_fit(tmp_path / "FM1" / "fit", tmp_path / "FM1" / "campaign.toml", inputs=inputs)
    write_budget(tmp_path / "budget", digest)
    return tmp_path


def by_name(index):
    return {(one.kind, one.name): one for one in index.entries}


def page(folder):
    return (folder / "index.html").read_text(encoding="utf-8")


def test_each_result_has_a_card_with_its_verdict_its_picture_and_the_way_to_its_page(bench):
    index = mechid.open_results(bench)
    assert [(one.kind, one.name) for one in index.entries] == [
        ("Campaigns", "FM1"),
        ("Fits", FIT),
        ("Budgets", "budget"),
    ]
    fit = index.entries[1]
    assert (fit.headline, fit.tone, fit.cautions) == ("Grade B", "good", ())
    assert fit.lines[-1] == "Record a is not followed."
    assert fit.picture == "FM1/fit/figures/a_torque.svg"
    assert fit.command == "mechid explore FM1/campaign.toml --fit FM1/fit"
    text = page(bench)
    assert 'href="FM1/fit/report.html?index=../../index.html"' in text
    assert 'src="FM1/fit/figures/a_torque.svg"' in text
    assert "1 of 1 requirements met" in text
    assert "mechid explore FM1/campaign.toml" in text
    assert "'self' file:" in text  # without it a browser shows no picture of another file


def test_its_text_and_its_numbers_are_those_of_the_page(bench):
    index = mechid.open_results(bench)
    assert "budget: 1 of 1 requirements met" in str(index)
    assert str(bench / "index.html") in str(index)
    assert index.to_dict()["entries"][1]["name"] == FIT
    assert repr(index) == f"<Index: 3 results in {bench}>"
    assert index.write(bench) == [bench / "index.html"]
    with pytest.raises(UsageError, match="is written there"):
        index.write(bench / "elsewhere")


def test_what_is_out_of_date_is_said(bench):
    write(bench / "FM1" / "data" / "a.csv", "time_s,torque_Nm\n0,1\n")
    found = by_name(mechid.open_results(bench))
    fit, budget = found["Fits", FIT], found["Budgets", "budget"]
    assert (fit.is_stale, fit.cautions) == (True, ("stale: a.csv changed since; identify anew",))
    assert (budget.is_stale, budget.cautions) == (True, ("stale: its fit is",))
    assert "3 results, 2 out of date" in page(bench)


def test_a_folder_without_results_is_refused_and_nothing_is_left(tmp_path):
    (tmp_path / "empty").mkdir()
    write(tmp_path / "profile.json", {"name": "of another program"})
    with pytest.raises(UsageError, match="holds no campaign and no result"):
        mechid.open_results(tmp_path)
    assert not (tmp_path / "index.html").exists()
    with pytest.raises(UsageError, match="is no folder"):
        mechid.open_results(tmp_path / "gone")


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("estimate.json", '{"format": "mechid-est', "cannot be read"),
        ("estimate.json", '{"format": "mechid-estimate/9"}', "found mechid-estimate/9"),
        ("estimate.json", '{"format": "mechid-estimate/1", "grade": "Z"}', "damaged at"),
        ("estimate.json", "[]", "no table"),
        ("estimate.json", "[" * 100_000, "cannot be read"),
        ("budget.json", '{"format": "mechid-budget/1", "requirements": 3}', "damaged at"),
        ("look.json", '{"format": "mechid-look/1", "records": [1], "left_out": []}', "damaged at"),
        ("fleet.json", "\x00", "cannot be read"),
        ("campaign.toml", "[[record]\n", "line 1"),
        ("campaign.toml", "record = 3\n", "damaged at"),
    ],
)
def test_the_card_of_a_damaged_result_says_so_and_the_others_stand(bench, name, content, said):
    write(bench / "broken" / name, content)
    index = mechid.open_results(bench)
    damaged = [one for one in index.entries if one.is_damaged]
    assert [one.name for one in damaged] == ["broken"]
    assert said in damaged[0].headline
    assert len(index.entries) == 4
    assert "1 damaged" in page(bench)


def test_a_pipe_or_a_folder_in_place_of_a_file_is_a_damaged_result(bench):
    os.mkfifo(bench / "look.json")
    (bench / "fleet.json").mkdir()
    assert {one.kind for one in mechid.open_results(bench).entries if one.is_damaged} == {"Looks", "Fleets"}


def test_links_in_circles_end_and_what_they_lead_to_is_found_once(bench, tmp_path_factory):
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    write_fit(elsewhere / "other")
    (bench / "a").mkdir()
    (bench / "a" / "up").symlink_to(bench)
    (bench / "a" / "itself").symlink_to(bench / "a" / "itself")
    (bench / "linked").symlink_to(elsewhere)
    (bench / "twice").symlink_to(elsewhere)
    (elsewhere / "back").symlink_to(bench)
    names = [one.name for one in mechid.open_results(bench).entries if one.kind == "Fits"]
    assert names == [FIT, str(Path("linked") / "other")]


def test_an_index_of_somebody_else_is_kept(bench):
    write(bench / "index.html", "<title>My bench</title>")
    with pytest.raises(UsageError, match="is not an index by mechid"):
        mechid.open_results(bench)
    assert page(bench) == "<title>My bench</title>"
    (bench / "index.html").unlink()
    mechid.open_results(bench)
    mechid.open_results(bench)  # its own is replaced


def test_names_of_folders_are_texts_and_addresses_not_markup(tmp_path):
    write_fit(tmp_path / "<b>&?#%'")
    write_fit(tmp_path / "javascript:alert(1)")
    mechid.open_results(tmp_path)
    text = page(tmp_path)
    assert "<b>&?" not in text
    assert 'href="%3Cb%3E%26%3F%23%25%27/report.html?index=../index.html"' in text
    assert 'href="javascript%3Aalert%281%29/report.html' in text


@pytest.mark.skipif(os.name == "nt", reason="its file names are Unicode")
def test_a_name_that_is_no_unicode_is_shown_all_the_same(tmp_path):
    folder = tmp_path / os.fsdecode(b"fit_\xff")
    try:
        folder.mkdir()
    except OSError:
        pytest.skip("this file system takes no such name")
    write_fit(folder)
    mechid.open_results(tmp_path)
    assert "fit_%FF/report.html" in page(tmp_path)


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may list every folder")
def test_a_folder_that_cannot_be_listed_is_named(bench):
    (bench / "shut").mkdir(mode=0)
    assert mechid.open_results(bench).unreadable == (str(bench / "shut"),)


def test_ten_thousand_files_take_less_than_five_seconds(tmp_path):
    """Truth: the clock; 500 fits with twenty files each, of which an index reads two."""
    for k in range(500):
        folder = tmp_path / f"set_{k % 20}" / f"fit_{k}"
        write_fit(folder)
        for j in range(16):
            (folder / f"part_{j}.csv").touch()
    began = time.perf_counter()
    index = index_of(tmp_path)
    assert time.perf_counter() - began < SECONDS
    assert len(index.entries) == 500
    assert sum(len(files) for _, _, files in os.walk(tmp_path)) >= FILES
