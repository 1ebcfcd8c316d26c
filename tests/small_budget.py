"""A budget of the paper's mechanism, small enough for tests: the example with few rates, and a hostile name."""

import pytest

import mechid
from mechid.budgets.example import BUDGET, write_example
from mechid.budgets.settings import LEVEL
from once import once
from paper_estimate import write_estimate_of_paper

HOSTILE = "<img src=x onerror=document.title='taken'>"
TEXT = (
    BUDGET.replace("{ from = 10.0, to = 60.0, count = 26 }", "{ from = 44.0, to = 50.0, count = 4 }")
    .replace("[[0.0, 0.0], [6.0, 60.0], [8.0, 60.0], [10.0, 0.0]]", "[[0.0, 0.0], [2.0, 60.0]]")
    .replace('name = "run up"', f'name = "{HOSTILE}"')
)
FEW = {"replicas": 4, "members": 16, "share_draws": 64, "missed_draws": 16}
"""Draws of its levels: whoever holds a level against a truth makes a budget of its own with all of them."""


def small_budget(tmp_path_factory):
    """Return the budget, made once in a run of the tests; not to be changed."""

    def make():
        folder = tmp_path_factory.mktemp("budget")
        write_estimate_of_paper(folder, fit_percent=99.0)
        write_example(folder)
        (folder / "budget.toml").write_text(TEXT, encoding="utf-8")
        with pytest.MonkeyPatch.context() as patched:
            for name, count in FEW.items():
                patched.setitem(vars(LEVEL), name, count)
            return mechid.budget(folder / "budget.toml")

    return once(tmp_path_factory, "small_budget", make)
