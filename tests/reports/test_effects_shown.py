"""The record that has most of what only some records have, as terminal, Markdown and page say it."""

import json
from dataclasses import replace

import pytest

from mechid.diagnoses.effect_rows import missing_data
from mechid.identification.result.missing_effects import EffectValue, Missing
from mechid.ink.in_markdown import document_markdown
from mechid.ink.on_page import interactive_page
from mechid.reports.document import PRESENTER
from mechid.reports.figure_cache import page_script
from mechid.reports.numbers import report_data
from mechid.reports.sections import report_document
from printing import printed


def clocks(**ppm):
    """Return own clocks of records, each a value and its standard error in ppm."""
    values = {f"record.{name}.clock_ppm": EffectValue(value=v, std_error=s, unit="ppm") for name, (v, s) in ppm.items()}
    own = {"chi_square": 900.0, "dof": len(ppm), "share": 0.5, "p_value": 0.0, "records": tuple(ppm), "toml": "[[own]]"}
    return Missing(name="record.clock", words="another rate in some records", parameters=values, **own)


ONE_APART = clocks(full=(0.7, 1.0), half=(-1.7, 2.0), sweep=(-200.1, 0.4))
SAID = ", most of all in sweep: -200.10 +- 0.40 ppm"
APART = {
    "one": (ONE_APART, SAID),
    "none beyond three errors": (clocks(a=(0.0, 1.0), b=(2.0, 1.0), c=(-2.0, 1.0)), ""),
    "the furthest is not known well": (clocks(a=(0.0, 1.0), b=(9.0, 1.0), c=(-30.0, 20.0), d=(0.1, 1.0)), " b: 9.0 "),
    "two": (clocks(a=(0.0, 1.0), b=(200.0, 1.0)), ""),
    "no error": (clocks(a=(0.0, 1.0), b=(0.0, 1.0), c=(200.0, None)), ""),
}


@pytest.mark.parametrize("case", APART)
def test_the_record_that_stands_out_is_named_where_one_does(case):
    """Truth: the values by hand; three standard errors from the median of at least three records."""
    missing, said = APART[case]
    apart = missing_data(missing)["text"]["apart"]
    assert said in apart if said else apart == ""


def test_terminal_markdown_and_page_say_it(make_fit, reported):
    """Truth: the sentence by hand."""
    assert f"another rate in some records{SAID} (below)" in printed(
        PRESENTER.print, report_data(replace(make_fit(), missing=(ONE_APART,))), 200
    )
    data = json.loads((reported.folder / "report.json").read_text(encoding="utf-8"))
    data["missing"] = [missing_data(ONE_APART)]
    document = report_document(data)
    for text in (document_markdown(document), "".join(interactive_page(document, {}, page_script([], [])))):
        assert f"beyond noise{SAID}." in text


@pytest.mark.parametrize(
    ("block", "toml", "where"),
    [
        ("", "clock_ppm = 3.0\n", "at the end of campaign.toml"),
        ("stepper.detent", "[[stepper.detent]]  # one harmonic\nperiod_deg = 0.9\n", "at the end of mechanism.toml"),
        ("friction", '# into the table\n# law = "stribeck"\n', "in the table that mechanism.toml has already"),
    ],
)
def test_it_says_where_the_text_belongs(block, toml, where):
    """Truth: a file has a table once, so that lines of one that stands there are comments at its end."""
    one = Missing(
        name="n", words="w", parameters={}, chi_square=99.0, dof=1, share=0.5, p_value=0.0, records=(), toml=toml,
        block=block,
    )  # fmt: skip
    assert missing_data(one)["text"]["where"] == where
