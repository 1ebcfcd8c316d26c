"""Finished fits that the functions begin from. Truth: the fit that was left, and the rules of the documentation."""

from dataclasses import replace

import pytest

import mechid
from fewer_records import keep_records
from mechid.campaign import mechanism_text
from mechid.campaign.bench import true_mechanism, write_bench
from mechid.errors import InputFileError, UsageError
from mechid.fits.load import campaign_first, campaign_of_fit, completed_file, fit_from, load_campaign_of, load_fit
from mechid.identification.result.estimate_file import estimate_text

STAGE = """
[[stage]]
records = ["full_46"]
window_s = [0.0, 0.03]
free = ["gear.stiffness", "gear.damping"]
"""


@pytest.fixture(scope="module")
def left(tmp_path_factory):
    """Return the folder of a campaign, that of its results, and the fit."""
    place = tmp_path_factory.mktemp("fits")
    write_bench(place / "bench", seed=3, sweep_s=1.0)
    keep_records(place / "bench", "full_46", "micro_46")
    unknown = true_mechanism().with_free(("gear.stiffness", "gear.damping"))
    (place / "bench" / "mechanism.toml").write_text(mechanism_text(unknown, "near"), encoding="utf-8")
    with (place / "bench" / "campaign.toml").open("a") as file:
        file.write(STAGE)
    done = mechid.identify_into(mechid.load_campaign(place / "bench"), place / "fit", workers=1)
    return place / "bench", place / "fit", done.fit


def test_a_folder_gives_the_fit_with_its_campaign(left):
    bench, folder, fit = left
    for read in (load_fit(folder), load_fit(str(folder), bench), load_fit(folder, fit.campaign), fit_from(folder)):
        assert replace(read, provenance=fit.provenance).to_dict() == fit.to_dict()
        assert read.folder == folder
        assert read.campaign.path.resolve() == (bench / "campaign.toml").resolve()
    assert load_campaign_of(folder).path.resolve() == (bench / "campaign.toml").resolve()


def test_results_beside_the_campaign_file_are_found(left, tmp_path):
    bench, folder, _ = left
    place = tmp_path / "bench"
    for source in (bench, folder):
        for file in source.iterdir():
            if file.is_file() and not (source == folder and file.name == "mechanism.toml"):
                place.mkdir(exist_ok=True)
                (place / file.name).write_bytes(file.read_bytes())
    read = load_fit(place / "campaign.toml")
    assert (read.folder, read.campaign.path) == (place, place / "campaign.toml")


def test_a_fit_in_memory_holds_its_campaign_or_is_given_it(left):
    _, _, fit = left
    assert fit_from(fit).campaign is fit.campaign
    bare = replace(fit, campaign=None)
    with pytest.raises(UsageError, match="does not hold its campaign; give campaign="):
        fit_from(bare)
    assert fit_from(bare, fit.campaign).campaign is fit.campaign
    assert fit_from(bare, fit.campaign.path).campaign.path == fit.campaign.path


@pytest.mark.parametrize("given", [{"grade": "A"}, None, 3])
def test_anything_else_is_refused(given):
    with pytest.raises(UsageError, match=r"fit: found a \w+; give a Fit, or the result folder of mechid identify"):
        fit_from(given)


def test_a_folder_that_is_not_there_is_named_itself(tmp_path):
    with pytest.raises(InputFileError, match=r"fit: there is no such folder or file; give the result folder"):
        load_fit(tmp_path / "fit")


def test_a_campaign_in_memory_wants_a_folder(left):
    bench, _, fit = left
    with pytest.raises(UsageError, match="is no folder; give the result folder of the fit"):
        load_fit(bench / "campaign.toml", fit.campaign)


def test_a_damaged_estimate_is_refused_before_its_records_are_read(left, tmp_path):
    _, folder, fit = left
    text = (folder / "estimate.json").read_text()
    (tmp_path / "estimate.json").write_text(text.replace('"correlation"', '"other"'))
    with pytest.raises(InputFileError, match="correlation: missing; the file is damaged or of another version"):
        load_fit(tmp_path, tmp_path / "nowhere.toml")
    assert estimate_text(fit)


def test_a_completed_fit_is_of_the_mechanism_that_it_was_completed_to(left):
    _, folder, fit = left
    assert completed_file(folder) is None
    assert campaign_of_fit(fit.campaign, fit) is fit.campaign
    own = campaign_of_fit(fit.campaign, replace(fit, completed=()))
    assert own is fit.campaign
    step = {"step": 1, "added": "friction.stribeck"}
    whole = campaign_of_fit(fit.campaign, replace(fit, completed=(step,)))
    assert whole.mechanism.value("gear.stiffness") == fit.parameters["gear.stiffness"].start


def test_the_campaign_may_come_first(left):
    """Truth: both orders give the function the same."""
    _, _, fit = left

    @campaign_first
    def asked(fit, name="", *, campaign=None):
        return fit, name, campaign

    assert asked(fit, "a")[1:] == ("a", None)
    assert asked(fit.campaign, fit, "a")[1:] == ("a", fit.campaign)
    assert asked(fit.campaign, fit=fit, name="a")[0] is fit
    assert asked(fit, campaign=fit.campaign)[2] is fit.campaign
