"""Every target hands on the mechanism as it flies, says so first, and hands on the bench where that is asked for."""

import csv
import json
import re
import zipfile
from dataclasses import replace

import numpy as np
import pytest

from golden_variants import VARIANTS
from layouts import mechanism_of
from mechid.errors import UsageError
from mechid.exports.c.compiler import found_compiler
from mechid.exports.c.target import Options as OfC
from mechid.exports.export import exported
from mechid.exports.fmu.options import Options as OfUnit
from mechid.exports.linear.options import Options as OfLinear
from mechid.exports.stand import handed_on, which_mechanism
from mechid.exports.tables.options import Options as OfTables
from mechid.plant.flight import in_flight
from mechid.simulation.simulator import Simulator, simulate_run

needs_compiler = pytest.mark.skipif(found_compiler() is None, reason="no C compiler is installed")
FLIES = "The mechanism as it flies, without [housing]; --option stand=yes hands on the bench."
STANDS = "The mechanism as on the bench, with [housing]; its base is at rest."
TARGETS = {"c": None, "fmu": None, "linear": OfLinear(rates=(), samples=2), "tables": OfTables(rates=(46.0,))}


@pytest.fixture(scope="module", params=TARGETS)
def done(request, paper, tmp_path_factory):
    """Return what each target has written by default."""
    return exported(paper, request.param, tmp_path_factory.mktemp(request.param), TARGETS[request.param])


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
@pytest.mark.parametrize("stand", [False, True])
def test_the_c_text_is_of_the_mechanism_that_it_says(paper, tmp_path, stand):
    """Truth: the kernel of the mechanism in flight, or of the bench; the file's own words, and its parameters."""
    done = exported(paper, "c", tmp_path, OfC(stand=stand))
    assert done.to_dict()["mechanism"] == (STANDS if stand else FLIES)
    assert done.written.checked.largest_error < 1e-9
    names = parameters_of((tmp_path / "mechanism.h").read_text(encoding="utf-8"))
    assert ("housing.frequency" in names) == stand
    assert names["gear.stiffness"] == paper.mechanism.value("gear.stiffness")


def test_what_is_handed_on_is_the_budget_s_mechanism(paper):
    """Truth: `in_flight`, on which budget, tables and linear models rest; the housing swings beside it."""
    trial = paper.trials[0]
    flying = torque(handed_on(paper.mechanism, {}, stand=False), trial)
    np.testing.assert_array_equal(flying, torque(in_flight(paper.mechanism), trial))
    bench = torque(handed_on(paper.mechanism, {}, stand=True), trial)
    np.testing.assert_array_equal(bench, torque(paper.mechanism, trial))
    assert np.std(bench - flying) > 0.01 * np.std(flying)


@needs_compiler
def test_the_c_text_and_the_unit_take_the_same_values(paper, tmp_path):
    """Truth: what differs in flight stands in the file."""
    asked = {"load.inertia": "0.02"}
    done = exported(paper, "c", tmp_path, asked)
    assert done.to_dict()["mechanism"] == f"{FLIES} With load.inertia = 0.02."
    assert parameters_of((tmp_path / "mechanism.h").read_text(encoding="utf-8"))["load.inertia"] == 0.02
    assert OfC.read(asked).values == OfUnit.read(asked).values == {"load.inertia": 0.02}


@pytest.mark.parametrize(("options", "what"), [(OfLinear, "linear models and forcing"), (OfTables, "lines")])
def test_what_there_is_in_flight_alone_is_not_handed_on_as_on_the_bench(options, what):
    with pytest.raises(UsageError, match=rf"--option stand: there are {what} .*alone; write the bench with --to c"):
        options.read({"stand": "yes"})
    assert options.read({"stand": "no"}) == options()
    with pytest.raises(UsageError, match='did you mean "stand"'):
        options.read({"stnad": "yes"})


@pytest.mark.parametrize("name", VARIANTS)
def test_any_mechanism_is_handed_on_without_its_test_stand(name):
    """Truth: the tables of each variant's file that belong to the bench; what drives it is what drove it."""
    bench = mechanism_of(VARIANTS[name])
    flying = handed_on(bench, {}, stand=False)
    tables = {parameter.split(".")[0] for parameter in flying.plant.declarations}
    assert not tables & {"housing", "transducer", "charge_amplifier", "anti_alias"}
    assert flying.plant.inputs == bench.plant.inputs
    assert list(flying.plant.outputs) == list(bench.plant.outputs)
    left = {parameter.rpartition(".")[0] for parameter in bench.plant.declarations.keys() - flying.plant.declarations}
    said = which_mechanism(bench, {}, stand=False)
    assert set(re.findall(r"\[([a-z_.]+)\]", said)) == left
    assert handed_on(bench, {}, stand=True).plant == bench.plant


def test_a_mechanism_without_test_stand_is_the_same_either_way():
    bench = mechanism_of(VARIANTS["current_driven_stepper"])
    for stand in (False, True):
        assert which_mechanism(bench, {}, stand=stand) == (
            "The mechanism as it flies, and as on the bench: it has no test stand."
        )


def test_one_that_comes_from_no_file_is_handed_on_as_it_is(paper):
    bench = replace(paper.mechanism, plant=replace(paper.mechanism.plant, layout=None))
    assert handed_on(bench, {}, stand=False).plant.layout is None
    assert "comes from no mechanism file" in which_mechanism(bench, {}, stand=False)
