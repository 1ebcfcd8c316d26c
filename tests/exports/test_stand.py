"""Every target hands on the mechanism as it flies, says so first, and hands on the bench where that is asked for."""

import csv
import json
import re
import zipfile
from dataclasses import replace

import numpy as np
import pytest

from export_bench import bench_of
from golden_variants import VARIANTS
from layouts import mechanism_of
from mechid.errors import UsageError
from mechid.exports.c.compiler import find_compiler
from mechid.exports.c.target import Options as OfC
from mechid.exports.export import write_export
from mechid.exports.fmu.options import Options as OfUnit
from mechid.exports.linear.options import Options as OfLinear
from mechid.exports.linear.target import AGREES
from mechid.exports.stand import describe_mechanism, select_mechanism
from mechid.exports.tables.options import Options as OfTables
from mechid.plant.flight import to_flight
from mechid.simulation.simulator import Simulator, simulate_run

needs_compiler = pytest.mark.skipif(find_compiler() is None, reason="no C compiler is installed")
FLIES = "The mechanism as it flies, without [housing]; --option stand=yes hands on the bench."
STANDS = "The mechanism as on the bench, with [housing]; its base is at rest."
NO_STAND = "The mechanism as it flies, and as on the bench: it has no test stand."
TARGETS = {
    "c": OfC(),
    "fmu": OfUnit(),
    "linear": OfLinear(rates=(46.0,), samples=2),
    "tables": OfTables(rates=(46.0,)),
}
FIRST_TEXTS = [pytest.param(one, marks=pytest.mark.slow) if one in ("fmu", "linear") else one for one in TARGETS]
TOLERANCE = {"c": 1e-9, "fmu": 1e-9, "linear": AGREES, "tables": 1e-7}
"""Of the largest error that each check may find: N m, of linear models relative."""


@pytest.fixture(scope="module", params=FIRST_TEXTS)
def done(request, paper, tmp_path_factory):
    """Return what each target has written by default."""
    return write_export(paper, request.param, tmp_path_factory.mktemp(request.param), TARGETS[request.param])


@pytest.fixture(
    scope="module", params=["c", *(pytest.param(one, marks=pytest.mark.slow) for one in TARGETS if one != "c")]
)
def either_way(request, paper, tmp_path_factory):
    """Return target, and what it has written as it flies and as on the bench: with a test stand, and without one."""
    target = request.param
    rigid = bench_of(paper, {"housing": None})
    with_stand, without = (
        [
            write_export(of, target, tmp_path_factory.mktemp(target), replace(TARGETS[target], stand=stand))
            for stand in (False, True)
        ]
        for of in (paper, rigid)
    )
    return target, with_stand, without


def numbers_of(done):
    """Return the numbers that a target's files hand on."""
    folder = done.folder
    if done.target == "linear":
        model = json.loads((folder / "linear.json").read_text(encoding="utf-8"))
        free, forced = model["models"]["free"], model["forcing"][0]
        return [free["C"][free["outputs"]["names"].index("torque")], free["D"], forced["amplitude"], forced["sigma"]]
    if done.target == "tables":
        return [
            (folder / name).read_text(encoding="utf-8").replace("transducer_torque", "base_torque")
            for name in ("lines.csv", "bands.csv", "history_full_46.csv")
        ]
    if done.target == "c":
        return parameters_of((folder / "mechanism.h").read_text(encoding="utf-8"))
    with zipfile.ZipFile(folder / done.written.files[0]) as archive:
        return parameters_of(archive.read("sources/mechanism.h").decode())


def torque(mechanism, trial):
    return simulate_run(Simulator(mechanism.plant, trial.command, trial.base).run(mechanism.kernel_values())).torque


def parameters_of(text):
    """Return the values in mechanism.h by dotted name."""
    return {name: float(value) for name, value in re.findall(r"/\* ([a-z_.0-9]+) = (\S+) ", text)}


def test_every_target_says_first_that_it_is_the_mechanism_in_flight(done):
    assert done.to_dict()["mechanism"] == FLIES
    content = json.loads((done.folder / "mechid_export.json").read_text(encoding="utf-8"))
    assert content["mechanism"] == content["provenance"]["mechanism"] == FLIES


def test_the_files_say_it_too(done):
    """Truth: one file of each kind that has room for words."""
    folder, plain = done.folder, " ".join(FLIES.split()[:7])
    if done.target == "c":
        texts = [(folder / name).read_text(encoding="utf-8") for name in ("mechanism.h", "mechanism.c")]
    elif done.target == "fmu":
        with zipfile.ZipFile(folder / done.written.files[0]) as archive:
            texts = [archive.read(n).decode() for n in ("modelDescription.xml", "sources/mechanism.c")]
    elif done.target == "linear":
        texts = [(folder / "linear.json").read_text(encoding="utf-8")]
    else:
        texts = [(folder / "lines.bdf").read_text(encoding="utf-8")]
        with (folder / "provenance.csv").open(encoding="utf-8", newline="") as file:
            assert ["mechanism", FLIES] in list(csv.reader(file))
    for text in texts:
        assert plain in " ".join(re.sub(r"\n[ *$]*", " ", text).split())


@needs_compiler
def test_every_target_says_first_which_of_both_it_is(either_way):
    """Truth: the sentence for a mechanism with a housing, and for one without anything that stays on the bench."""
    _, with_stand, without = either_way
    for done, said in zip((*with_stand, *without), (FLIES, STANDS, NO_STAND, NO_STAND), strict=True):
        content = json.loads((done.folder / "mechid_export.json").read_text(encoding="utf-8"))
        assert content["mechanism"] == content["provenance"]["mechanism"] == said
        assert done.provenance["mechanism"] == said


@needs_compiler
def test_the_numbers_differ_where_there_is_a_stand_and_only_there(either_way):
    _, with_stand, without = either_way
    flying, bench = map(numbers_of, with_stand)
    assert all(a != b for a, b in zip(flying, bench, strict=True)) if isinstance(flying, list) else flying != bench
    assert numbers_of(without[0]) == numbers_of(without[1])


@needs_compiler
def test_every_target_is_held_against_what_it_says_that_it_is(either_way):
    """Truth: mechid's own kernel or equations of the bench; the tolerances of the flying mechanism."""
    target, *every = either_way
    for done in [one for pair in every for one in pair]:
        assert done.written.checked.largest_error < TOLERANCE[target]


@needs_compiler
@pytest.mark.parametrize("stand", [False, True])
def test_the_c_text_is_of_the_mechanism_that_it_says(paper, tmp_path, stand):
    """Truth: the kernel of the mechanism in flight, or of the bench; the file's own words, and its parameters."""
    done = write_export(paper, "c", tmp_path, OfC(stand=stand))
    assert done.to_dict()["mechanism"] == (STANDS if stand else FLIES)
    assert done.written.checked.largest_error < 1e-9
    names = parameters_of((tmp_path / "mechanism.h").read_text(encoding="utf-8"))
    assert ("housing.frequency" in names) == stand
    assert names["gear.stiffness"] == paper.mechanism.value("gear.stiffness")


def test_what_is_handed_on_is_the_budget_s_mechanism(paper):
    """Truth: `to_flight`, on which budget, tables and linear models rest; the housing swings beside it."""
    trial = paper.trials[0]
    flying = torque(select_mechanism(paper.mechanism, {}, stand=False), trial)
    np.testing.assert_array_equal(flying, torque(to_flight(paper.mechanism), trial))
    bench = torque(select_mechanism(paper.mechanism, {}, stand=True), trial)
    np.testing.assert_array_equal(bench, torque(paper.mechanism, trial))
    assert np.std(bench - flying) > 0.01 * np.std(flying)


@needs_compiler
def test_the_c_text_and_the_unit_take_the_same_values(paper, tmp_path):
    """Truth: what differs in flight stands in the file."""
    asked = {"load.inertia": "0.02"}
    done = write_export(paper, "c", tmp_path, asked)
    assert done.to_dict()["mechanism"] == f"{FLIES} With load.inertia = 0.02."
    assert parameters_of((tmp_path / "mechanism.h").read_text(encoding="utf-8"))["load.inertia"] == 0.02
    assert OfC.read(asked).values == OfUnit.read(asked).values == {"load.inertia": 0.02}


@pytest.mark.parametrize("options", [OfC, OfUnit, OfLinear, OfTables])
def test_every_target_reads_the_option(options):
    assert options.read({"stand": "yes"}) == options(stand=True)
    assert options.read({"stand": "no"}) == options()
    with pytest.raises(UsageError, match=r'--option stand: found "maybe"'):
        options.read({"stand": "maybe"})
    with pytest.raises(UsageError, match='did you mean "stand"'):
        options.read({"stnad": "yes"})


@pytest.mark.parametrize("name", VARIANTS)
def test_any_mechanism_is_handed_on_without_its_test_stand(name):
    """Truth: the tables of each variant's file that belong to the bench; what drives it is what drove it."""
    bench = mechanism_of(VARIANTS[name])
    flying = select_mechanism(bench, {}, stand=False)
    tables = {parameter.split(".")[0] for parameter in flying.plant.declarations}
    assert not tables & {"housing", "transducer", "charge_amplifier", "anti_alias"}
    assert flying.plant.inputs == bench.plant.inputs
    assert list(flying.plant.outputs) == list(bench.plant.outputs)
    left = {parameter.rpartition(".")[0] for parameter in bench.plant.declarations.keys() - flying.plant.declarations}
    said = describe_mechanism(bench, {}, stand=False)
    assert set(re.findall(r"\[([a-z_.]+)\]", said)) == left
    assert select_mechanism(bench, {}, stand=True).plant == bench.plant


def test_a_mechanism_without_test_stand_is_the_same_either_way():
    bench = mechanism_of(VARIANTS["current_driven_stepper"])
    for stand in (False, True):
        assert describe_mechanism(bench, {}, stand=stand) == (
            "The mechanism as it flies, and as on the bench: it has no test stand."
        )


def test_one_that_comes_from_no_file_is_handed_on_as_it_is(paper):
    bench = replace(paper.mechanism, plant=replace(paper.mechanism.plant, layout=None))
    assert select_mechanism(bench, {}, stand=False).plant.layout is None
    assert "comes from no mechanism file" in describe_mechanism(bench, {}, stand=False)
