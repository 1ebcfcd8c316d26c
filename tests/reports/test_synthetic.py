"""The word "synthetic" where records were simulated. Truth: what the campaign file says of its records."""

import io
import json
from dataclasses import replace

import pytest
from rich.console import Console

import mechid
from mechid.campaign.bench import TRUTH, write_bench
from mechid.campaign.campaign_file import TRUTH_NAME, load_campaign
from mechid.checks.document import PRESENTER
from mechid.checks.numbers import check_numbers
from mechid.display import SYNTHETIC
from mechid.errors import InputFileError
from mechid.identification.result.estimate_file import is_synthetic, write_estimate
from mechid.identification.result.fit_file import read_fit
from mechid.reports.numbers import report_data


@pytest.fixture
def bench(tmp_path):
    """Return the file of a synthetic campaign of short records."""
    return write_bench(tmp_path / "bench", sweep_s=0.5)


def unread(path):
    return load_campaign(path, read_records=False)


def printed(write, data):
    stream = io.StringIO()
    write(data, Console(file=stream, width=200))
    return stream.getvalue()


def test_a_bench_says_so_and_its_copy_without_the_truth_too(bench):
    assert unread(bench).synthetic
    (bench.parent / TRUTH_NAME).unlink()
    assert unread(bench).synthetic


def test_an_older_bench_is_told_by_its_truth_and_a_file_may_say_otherwise(bench):
    text = bench.read_text(encoding="utf-8")
    assert "\nsynthetic = true\n" in text
    bench.write_text(text.replace("synthetic = true\n", ""), encoding="utf-8")
    assert unread(bench).synthetic
    (bench.parent / TRUTH_NAME).rename(bench.parent / "other.json")
    assert not unread(bench).synthetic
    (bench.parent / TRUTH_NAME).write_text(json.dumps(TRUTH), encoding="utf-8")
    bench.write_text(text.replace("synthetic = true", "synthetic = false"), encoding="utf-8")
    assert not unread(bench).synthetic


@pytest.mark.parametrize("found", ['"yes"', "1", "[true]"])
def test_what_is_neither_true_nor_false_is_refused(bench, found):
    text = bench.read_text(encoding="utf-8").replace("synthetic = true", f"synthetic = {found}")
    bench.write_text(text, encoding="utf-8")
    with pytest.raises(InputFileError, match=r"synthetic.*write true or false"):
        unread(bench)


@pytest.mark.parametrize("is_so", [True, False])
def test_a_campaign_in_code_says_it_by_its_entries_and_so_do_its_files(tmp_path, is_so):
    record = mechid.make_record("full_46", command=mechid.make_command("full", rate=46.0))
    entries = {"synthetic": True} if is_so else {}
    campaign = mechid.make_campaign(mechid.catalogue_mechanism(), record, entries=entries)
    assert campaign.synthetic == is_so
    mechid.write_campaign(campaign, tmp_path / "written")
    assert unread(tmp_path / "written").synthetic == is_so


@pytest.mark.parametrize("is_so", [True, False])
def test_an_estimate_carries_it_and_one_of_an_earlier_version_is_read(reported, tmp_path, is_so):
    write_estimate(replace(reported.fit, synthetic=is_so), tmp_path / "estimate.json")
    content = json.loads((tmp_path / "estimate.json").read_text(encoding="utf-8"))
    assert content["synthetic"] is is_so
    assert is_synthetic(content) == is_so
    assert read_fit(tmp_path / "estimate.json", reported.campaign).synthetic == is_so
    del content["synthetic"]
    (tmp_path / "estimate.json").write_text(json.dumps(content), encoding="utf-8")
    assert not read_fit(tmp_path / "estimate.json", reported.campaign).synthetic
    assert not is_synthetic(content)


def test_a_fit_of_a_synthetic_campaign_is_so(reported):
    campaign = replace(reported.campaign, synthetic=True)
    fit = mechid.identify(campaign, workers=1)
    assert fit.synthetic
    assert report_data(fit)["synthetic"]
    assert not report_data(reported.fit)["synthetic"]
    assert SYNTHETIC in printed(PRESENTER.print, check_numbers(campaign))
    assert SYNTHETIC not in printed(PRESENTER.print, check_numbers(reported.campaign))
