"""Terms added to a mechanism: their plant, their priors, which are needed, and what a fit with them says."""

from dataclasses import replace

import numpy as np
import pytest

from mechid.campaign import catalogue_mechanism
from mechid.campaign.catalogue_values import CATALOGUE
from mechid.campaign.identify_options import IdentifyOptions
from mechid.campaign.mechanism_file import mechanism_from_table
from mechid.identification.effects.effect import add_terms, share_kernel
from mechid.identification.identify import identify, make_problem
from mechid.identification.output_error.problem import transfer_values
from mechid.identification.result.grade import Cause, Grade
from mechid.kernel.source import fingerprint, lanes_for
from mechid.plant.superset import rivals_of, superset_of
from synthetic import COMMANDS, TRUTH, bench, campaign, displaced, measured, record, torque_of, truth

NAMES = ["stepper.torque_harmonic:3", "stepper.detent:0.9deg", "gear.kinematic_error:2"]


@pytest.mark.slow
@pytest.mark.parametrize("grown_only", [True, False])
def test_a_superset_at_its_null_is_the_mechanism(grown_only):
    """Truth: the mechanism itself; what its terms are worth at null is nothing but rounding."""
    plain = truth()
    wide = superset_of(plain, grown_only=grown_only).mechanism
    runs = [torque_of(m, COMMANDS["full_46"], 1000) for m in (plain, wide)]
    assert np.abs(runs[1] - runs[0]).max() < 1e-9 * np.abs(runs[0]).max()


def test_terms_are_named_and_free_from_their_null():
    superset = superset_of(truth())
    names = [term.name for term in superset.terms]
    assert set(NAMES) <= set(names)
    assert "stepper.detent:1.8deg" not in names, "the file has it"
    free = superset.with_free_terms(NAMES)
    new = [p for p in free.free if p.name not in truth().parameters]
    assert [p.value for p in new] == [0.0] * 6
    assert {p.name.rpartition(".")[2] for p in new} == {"amplitude", "phase_deg"}
    assert free.plant is superset.mechanism.plant, "nothing is compiled anew when other terms are free"
    added = add_terms(superset, NAMES)
    assert set(added.new) == {p.name for p in new}
    assert set(added.terms) == set(NAMES)


def test_a_law_stands_in_place_only_where_no_parameter_is_lost():
    plain = catalogue_mechanism()
    laws = [law.name for law in rivals_of(plain)]
    assert {"friction.stribeck", "gear.backlash", "output_friction", "anti_alias:4", "charge_amplifier"} <= set(laws)
    table = {**CATALOGUE, "friction": {**CATALOGUE["friction"], "law": "stribeck", "stribeck_rate": 2.0}}
    laws = [law.name for law in rivals_of(mechanism_from_table(table, "stribeck"))]
    assert "friction.load_dependent" not in laws, "it would take stribeck_rate away"


def wide_problem():
    """Return the problem of a short record with some terms free, and that of the mechanism alone."""
    made = bench(displaced(truth(), {"gear.stiffness": 1.01}), truth(), "full_46", seed=5, seconds=0.05)
    plain, superset = make_problem(made, 1), superset_of(made.mechanism, only=NAMES)
    added = add_terms(superset, NAMES)
    wide = share_kernel(added.problem(plain), superset)
    return plain, wide, added


def test_a_start_is_transferred_to_the_null_of_its_terms():
    plain, wide, added = wide_problem()
    q = transfer_values(plain, plain.start, wide)
    values = wide.coordinates.values(q)
    assert {n: values[n] for n in plain.coordinates.values(plain.start)} == pytest.approx(
        plain.coordinates.values(plain.start)
    )
    assert [values[name] for name in sorted(added.new)] == [0.0] * 6
    assert wide.total_norm(q, wide.whole_windows()) == pytest.approx(
        plain.total_norm(plain.start, plain.whole_windows()), rel=1e-9
    )


def test_any_choice_of_terms_shares_a_kernel():
    """Truth: the digest by which kernels are kept, of the plant and the number of lanes."""
    plain, wide, _ = wide_problem()
    superset = superset_of(plain.space.mechanism, only=NAMES)
    every = share_kernel(add_terms(superset, [term.name for term in superset.terms]).problem(plain), superset)
    names = {fingerprint(p.space.mechanism.plant, lanes_for(p.coordinates.lanes)) for p in (wide, every)}
    assert len(names) == 1


def test_small_priors_are_of_both_parts_of_a_pair_and_have_their_derivative():
    """Truth: q / width by hand, and differences."""
    _, wide, added = wide_problem()
    at = np.random.default_rng(1).normal(0.0, 1e-4, wide.size) + wide.start
    away, J = wide.coordinates.prior_rows(at)
    assert away.size == 6
    places = [j for j, c in enumerate(wide.space.coordinates) if c.name in added.widths]
    assert away == pytest.approx([at[j] / added.widths[wide.coordinates.names[j]] for j in places])
    step = 1e-6 * np.ones(wide.size)
    assert J @ step == pytest.approx(wide.coordinates.prior_rows(at + step)[0] - away, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("allowed", [True, False])
def test_records_are_followed_although_the_file_lacks_a_harmonic(allowed):
    """Truth: the mechanism that made the records, with a harmonic of the torque constant that the file lacks."""
    table = {
        **CATALOGUE,
        "stepper": {**CATALOGUE["stepper"], "torque_harmonic": [{"order": 3, "amplitude": 0.06, "phase_deg": 40.0}]},
    }
    made_by = mechanism_from_table(table, "with a harmonic").with_values(TRUTH)
    names = ("full_46", "full_23", "micro_46")
    records = [
        record(n, measured(made_by, COMMANDS[n], np.random.default_rng((7, k)), seconds=0.5), COMMANDS[n])
        for k, n in enumerate(names)
    ]
    made = campaign(catalogue_mechanism(), *records)
    fit = identify(replace(made, options=IdentifyOptions(terms=allowed)), workers=2)
    causes = [reason.cause for reason in fit.reasons]
    assert (Cause.INCOMPLETE in causes) is allowed
    added = {n for n, p in fit.parameters.items() if p.added}
    own = {n for n in fit.parameters if n.startswith("record.")}
    assert set(fit.parameters) - added - own == set(made.mechanism.parameters)
    assert bool(added - {"transducer.gain"}) is allowed, "a table that gains of records need is no term"
    if allowed:
        assert fit.grade is Grade.B
        assert [one.name for one in fit.missing] == ["stepper.torque_harmonic:3"], "the others are not needed"
        off = [abs(p.value - TRUTH[n]) / p.std_error for n, p in fit.parameters.items() if p.std_error and not p.added]
        assert len(off) >= 10
        assert np.sqrt(np.mean(np.square(off))) < 2.5


@pytest.mark.slow
def test_a_low_pass_is_not_called_delays_of_the_records():
    """Truth: the mechanism that made the records, and a filter of order 2 at 1.9 kHz that the file lacks."""
    made_by = mechanism_from_table({**CATALOGUE, "anti_alias": {"order": 2, "frequency": 12e3}}, "filtered")
    made_by = made_by.with_values(TRUTH)
    records = [
        record(n, measured(made_by, COMMANDS[n], np.random.default_rng((8, k)), seconds=0.3), COMMANDS[n])
        for k, n in enumerate(("full_46", "full_23", "micro_46"))
    ]
    made = campaign(catalogue_mechanism(), *records)
    fit = identify(made, workers=1, near=TRUTH)
    assert [one.name for one in fit.missing] == ["anti_alias"], "no delay stands beside it"
    assert fit.grade is Grade.B
    assert fit.parameters["anti_alias.frequency"].value == pytest.approx(12e3, rel=0.01)
    off = [abs(p.value - TRUTH[n]) / p.std_error for n, p in fit.parameters.items() if p.std_error and not p.added]
    assert np.sqrt(np.mean(np.square(off))) < 1.6


@pytest.mark.slow
@pytest.mark.parametrize(("late_s", "near"), [(0.0, TRUTH), (1e-3, None)])
def test_a_high_pass_is_not_called_delays_and_stands_beside_real_ones(late_s, near):
    """Truth: a charge amplifier of 0.2 s that the file lacks, and in the second case records that begin late.

    A warm start takes what delays leave at the given values for noise, so that case is searched for.
    """
    made_by = mechanism_from_table({**CATALOGUE, "charge_amplifier": {"time_constant": 0.2}}, "high-pass")
    made_by = made_by.with_values(TRUTH)
    late = dict(zip(("full_46", "full_23", "micro_46"), (late_s, -0.7 * late_s, 0.4 * late_s), strict=True))
    records = [
        record(
            n,
            measured(made_by, COMMANDS[n], np.random.default_rng((8, k)), seconds=0.3, time_offset_s=offset),
            COMMANDS[n],
        )
        for k, (n, offset) in enumerate(late.items())
    ]
    fit = identify(campaign(catalogue_mechanism(), *records), workers=1, near=near)
    assert {one.name for one in fit.missing} == {"charge_amplifier", *(["record.delay"] if late_s else [])}
    assert fit.parameters["charge_amplifier.time_constant"].value == pytest.approx(0.2, rel=0.05)
