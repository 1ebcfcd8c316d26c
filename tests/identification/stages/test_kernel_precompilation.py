"""Kernels compiled beside a search. Truth: the cache's folder, and the system's own word on processes."""

import os
from dataclasses import replace

import pytest

from mechid.campaign.identify_options import IdentifyOptions
from mechid.identification.identify import make_problem
from mechid.identification.stages import kernel_precompilation
from mechid.identification.stages.families import ALL_TERMS, EVERYTHING, RECORDS, Families
from mechid.identification.stages.kernel_precompilation import KernelsAhead, layouts
from synthetic import bench, truth


@pytest.fixture(scope="module")
def campaign():
    return bench(truth(), truth(), "full_46", seed=5, seconds=0.1)


@pytest.fixture(scope="module")
def problem(campaign):
    return make_problem(campaign, 1)


@pytest.fixture
def two_cores(monkeypatch, tmp_path):
    """Let the cache be empty and the machine have two cores."""
    monkeypatch.setenv("MECHID_CACHE", str(tmp_path))
    monkeypatch.setattr(kernel_precompilation, "usable_cores", lambda: 2)


def test_values_of_records_come_first_then_the_superset_and_the_laws_in_their_order(campaign, problem):
    families = Families(problem, campaign)
    found = list(layouts(families))
    records = families.model(RECORDS).problem
    assert found[0][0].digest == records.space.mechanism.plant.digest
    assert found[0][1] == records.coordinates.lanes
    assert found[1][0] is families.superset.mechanism.plant
    assert [plant for plant, _ in found[2:]] == [law.mechanism.plant for law in families.laws()]
    assert [wanted for _, wanted in found[2:]] == [families.model_with_law(law).problem.size for law in families.laws()]


def test_without_terms_there_is_no_law_to_compile(campaign, problem):
    one = replace(campaign, options=IdentifyOptions(terms=False))
    assert len(list(layouts(Families(problem, one)))) == 1


@pytest.mark.slow
def test_models_of_one_plant_share_a_kernel(campaign, problem):
    """Truth: the lanes that a kernel is made for; the derivatives are those of a kernel with no spare lanes."""
    families = Families(problem, campaign)
    wide = families.model(EVERYTHING)
    single = families.with_effect(families.bare, families.superset.terms[0].name)
    lanes = {m.problem.coordinates.lanes for m in (wide, single, families.model(ALL_TERMS))}
    assert lanes == {len(families.superset.mechanism.plant.parameters)}
    assert lanes.pop() >= wide.problem.space.size
    tight = replace(single.problem, capacity=0)
    assert tight.coordinates.lanes == tight.space.size
    q, windows = single.problem.start, single.problem.whole_windows()
    assert (single.problem.joint(q, windows).jacobian == tight.joint(q, windows).jacobian).all()


@pytest.mark.usefixtures("two_cores")
def test_a_search_starts_it_once_for_a_mechanism(campaign, problem, tmp_path):
    with KernelsAhead(problem, campaign) as ahead:
        assert ahead.start_if_new()
        child = ahead._child
        assert child.poll() is None
        assert not ahead.start_if_missing(Families(problem, campaign)), "it is at work already"
    assert child.returncode is not None, "it has not outlived the search"
    assert list(tmp_path.rglob("ahead_*.txt"))
    with KernelsAhead(problem, campaign) as again:
        assert not again.start_if_new()
        assert again.start_if_missing(Families(problem, campaign)), "the layouts are not there yet"


@pytest.mark.usefixtures("two_cores")
def test_it_ends_with_a_search_that_was_killed(campaign, problem):
    """Truth: the end of the pipe, which is all that a killed process leaves."""
    with KernelsAhead(problem, campaign) as ahead:
        assert ahead.start_if_new()
        ahead._child.stdin.close()
        assert ahead._child.wait(timeout=60) == 0
        ahead._child.stdin = None


@pytest.mark.usefixtures("two_cores")
def test_what_goes_wrong_there_is_no_fault_of_the_search(campaign, problem, monkeypatch):
    monkeypatch.setattr(kernel_precompilation, "START", "raise SystemExit(3)  # {path} {module}")
    with KernelsAhead(problem, campaign) as ahead:
        ahead.start_if_new()
        assert ahead._child.wait(timeout=60) == 3
    monkeypatch.setattr(kernel_precompilation.sys, "executable", os.devnull)
    with KernelsAhead(problem, campaign) as ahead:
        assert not ahead.start_if_missing(Families(problem, campaign))


@pytest.mark.usefixtures("two_cores")
def test_it_is_not_started_without_a_core_or_a_need(campaign, problem, monkeypatch):
    families = Families(problem, campaign)
    monkeypatch.setattr(kernel_precompilation, "is_compiled", lambda plant, wanted: True)
    assert not KernelsAhead(problem, campaign).start_if_missing(families)
    monkeypatch.setattr(kernel_precompilation, "is_compiled", lambda plant, wanted: False)
    monkeypatch.setattr(kernel_precompilation, "usable_cores", lambda: 1)
    assert not KernelsAhead(problem, campaign).start_if_missing(families)
    assert not KernelsAhead(problem, campaign).start_if_new()


def test_layouts_are_compiled_where_the_process_is_told_of_them(campaign, problem, monkeypatch):
    """Truth: what the process asks to have compiled, of a message as the search sends it."""
    import io
    import pickle
    from functools import partial
    from types import SimpleNamespace

    families = KernelsAhead(problem, campaign)._families_without_records
    sent = pickle.dumps(partial(layouts, families, problem.coordinates.lanes))
    asked = []
    monkeypatch.setattr(kernel_precompilation, "kernel_for", lambda plant, wanted: asked.append((plant.digest, wanted)))
    monkeypatch.setattr(kernel_precompilation, "Thread", lambda **_: SimpleNamespace(start=lambda: None))
    monkeypatch.setattr(kernel_precompilation.sys, "stdin", SimpleNamespace(buffer=io.BytesIO(sent)))
    kernel_precompilation.compile_layouts()
    assert asked == [(plant.digest, wanted) for plant, wanted in layouts(Families(problem, campaign))]
