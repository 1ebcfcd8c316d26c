"""What a mechanism is without what stands beside it. Truth: the mechanism as it was before that was put there."""

import pytest

from layouts import paper_with
from mechid.campaign import catalogue_mechanism
from mechid.plant.subset import nulls_of, subset_of
from mechid.plant.superset import rivals_of, superset_of

RIVALS = [law.name for law in rivals_of(catalogue_mechanism())]


def tables(names):
    return {name.rpartition(".")[0] for name in names}


def test_a_superset_without_its_terms_is_the_mechanism():
    mechanism = catalogue_mechanism()
    superset = superset_of(mechanism)
    less = subset_of(superset.mechanism, mechanism, tables(superset.term_of))
    assert less == mechanism


@pytest.mark.parametrize("name", RIVALS)
def test_a_mechanism_without_a_law_in_place_of_another_is_the_mechanism(name):
    mechanism = catalogue_mechanism()
    law = next(law for law in rivals_of(mechanism) if law.name == name)
    assert subset_of(law.mechanism, mechanism, tables(law.own)) == mechanism


def test_a_table_stays_that_the_other_mechanism_has_too():
    mechanism = paper_with({"stepper": {"imbalance": {"resistance": 0.03}}})
    superset = superset_of(mechanism, only=("stepper.phase_offset", "stepper.detent:7.2deg"))
    less = subset_of(superset.mechanism, mechanism, {"stepper.imbalance", "stepper.detent.0", "stepper.detent.2"})
    assert less == mechanism


def test_the_nulls_of_terms_are_where_a_superset_has_them():
    superset = superset_of(catalogue_mechanism())
    assert nulls_of(superset.mechanism, superset.widths) == {n: superset.mechanism.value(n) for n in superset.widths}
    assert not nulls_of(superset.mechanism, (n for n in superset.term_of if n not in superset.widths))
