"""The document of a diagnosis. Truth: a diagnosis written by hand, of one effect that another one imitates."""

from mechid.diagnoses.document import diagnosis_document, next_lines, sentence
from mechid.ink.in_markdown import document_markdown
from mechid.ink.on_page import document_page
from mechid.ink.on_terminal import print_document
from printing import printed

EFFECT = {
    "name": "gear.backlash",
    "words": "play in the gear",
    "chi_square": 900.0,
    "dof": 1,
    "aliases": ["friction.stribeck"],
    "rows": [{"name": "gear.backlash", "text": {"value": "2.0e-04", "std_error": "1.0e-05", "unit": "rad"}}],
    "places": [{"record": "sweep", "frequencies_hz": [31.0], "kind": "lines", "text": "31 Hz"}],
    "toml": "[gear]\nbacklash = 2e-4\n",
    "text": {
        "name": "gear.backlash",
        "chi_square": "900",
        "share_percent": "40",
        "records": "sweep",
        "aliases": "friction.stribeck",
    },
}
DATA = {
    "synthetic": False,
    "unexplained": {"share": 0.1, "words": "One tenth of the misfit is left."},
    "missing": [EFFECT],
    "evidence": ["The criterion prefers it."],
    "path": [],
    "tried": [{"name": "clock", "words": "another clock", "why": "explains nothing"}],
    "drawn": {"spectra": [{"record": "sweep", "figure": "diagnosis_sweep_spectrum"}], "stretch": None},
}
SENTENCE = (
    "Play in the gear: it explains 40 % of the misfit (chi-square 900 for 1), in the records sweep; "
    "these records cannot tell it from friction.stribeck."
)


def test_every_printer_says_the_same():
    document = diagnosis_document(DATA)
    markdown, page = document_markdown(document), document_page(document, {})
    terminal = printed(print_document, document, 160)
    assert sentence(EFFECT) == SENTENCE
    for text in (markdown, page):
        assert SENTENCE in text.replace("\\_", "_")
        assert "What declares it" in page
    for text in (markdown, page, terminal):
        assert "One tenth of the misfit is left." in text
        assert "The criterion prefers it." in text
        assert "explains nothing" in text
    assert "evidence: The criterion prefers it." in terminal
    assert terminal.count("The criterion prefers it.") == 1
    assert markdown.count("The criterion prefers it.") == 1
    assert page.count("The criterion prefers it.") == 1
    assert "missing: gear.backlash: play in the gear" in terminal
    assert "acts: gear.backlash: at 31 Hz" in terminal


def test_effects_that_cannot_be_told_apart_lead_to_a_design():
    """Truth: an effect with an alias, and one without."""
    assert len(next_lines(DATA)) == 2
    assert len(next_lines({**DATA, "missing": [{**EFFECT, "aliases": []}]})) == 1


def test_where_nothing_is_missing_there_is_one_line():
    """Truth: a fit that explains all."""
    none = {**DATA, "missing": [], "evidence": [], "tried": [], "drawn": {"spectra": [], "stretch": None}}
    document = diagnosis_document(none)
    assert document_markdown(document) == "# What the model is missing\n\n**One tenth of the misfit is left.**\n"
    assert document.contents() == []
