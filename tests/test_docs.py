"""The pages on what mechid does. Truth: mechid itself, and that what is done is not called something to come."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

import synthetic
from mechid.campaign import catalogue_mechanism
from mechid.campaign.identify_options import IdentifyOptions
from mechid.errors import InputFileError
from mechid.identification.identify import make_problem
from mechid.parameter import Status

ROOT = Path(__file__).parents[1]
PAGES = sorted([ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").rglob("*.md")])
DONE = "(?:used|judged|told|done|made|supported|implemented)"
TO_COME = re.compile(
    rf"\bnot {DONE}\b[^.;|]{{0,40}}\b(?:yet|so far)\b|\bnot yet {DONE}\b|\b{DONE}\b[^.;|]{{0,40}}\bso far\b"
    rf"|\b(?:layers|blocks|commands) to come\b|\bwill be {DONE}\b|\bin a later (?:issue|version)\b",
    re.IGNORECASE,
)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_no_page_says_that_something_is_not_done_yet(page):
    """What is not done stands under a heading of limits; what is done is said."""
    text = " ".join(page.read_text(encoding="utf-8").split())
    assert TO_COME.findall(text) == []


@pytest.mark.parametrize(
    "stale",
    [
        "(such channels are read, and not used yet; mechid does not refuse a free $U$)",
        "Such grazing switches are not told by the fit so far; a run can log each",
        "a prior (`sigma`) is read, and not used yet.",
        "- **Grazing switches are logged, not yet judged.** A run can log",
        "no warning is made from them so far.",
        "Layers to come stand in the contract",
    ],
)
def test_such_sentences_are_found(stale):
    """Truth: the sentences that stood in the pages after what they speak of had been done."""
    assert TO_COME.search(stale)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_a_test_that_a_page_names_is_there(page):
    """Truth: the files; a page that says what holds it is worth what its test is."""
    named = re.findall(r"\btests/(?:[\w.-]+/)*(?:[\w-]+\.py)?", page.read_text(encoding="utf-8"))
    assert [name for name in named if not (ROOT / name).exists()] == []


def page(name):
    return " ".join((ROOT / "docs" / name).read_text(encoding="utf-8").split())


def test_a_free_voltage_is_refused_as_its_page_says():
    assert "mechid refuses that" in page("blocks/voltage_stepping.md")
    mechanism = catalogue_mechanism()
    voltage = replace(mechanism.parameters["stepper.peak_voltage"], status=Status.FREE, min=4.0, max=7.0)
    campaign = synthetic.bench(
        mechanism.with_parameters({voltage.name: voltage}), synthetic.truth(), "full_46", seed=1, seconds=0.05
    )
    with pytest.raises(InputFileError, match="free together with R, L and k_m"):
        make_problem(campaign, 1)


def test_a_prior_counts_as_the_page_of_the_load_says():
    assert "or give one of them a [prior]" in page("blocks/load.md")
    assert IdentifyOptions().priors == "fit"
