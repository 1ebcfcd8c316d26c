"""The units for FMI 2.0 and 3.0: what they give beside the kernel, whatever the communication step, and refuse."""

import ctypes as ct
import shutil
import subprocess
import sys
import zipfile
from contextlib import ExitStack
from dataclasses import replace

import numpy as np
import pytest

from layouts import changed, mechanism_of, paper_table
from mechid.command import Command, Excitation, RateProfile
from mechid.errors import InputFileError, UsageError
from mechid.exports.c.compiler import find_compiler
from mechid.exports.document import PAGES
from mechid.exports.export import write_export
from mechid.exports.fmu.importer import Importer
from mechid.exports.fmu.options import Options
from mechid.exports.fmu.unit import without_ports
from mechid.exports.fmu.variables import INPUT, PARAMETER
from mechid.exports.handover import Trial
from mechid.simulation.simulator import Simulator, TimeBase, simulate_run

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler is installed")
SWEEP = Command(stepping="micro", microsteps=16, rate=RateProfile.through([(0.0, 0.0), (2.0, 60.0)]))
RATE_HZ, SECONDS = 10_000.0, 1.0
MODE, INDEX, RATE, VOLTAGE_A = 1, 10, 11, 12
ERROR = 3
FMPY = shutil.which("fmpy")


class Driven(Importer):
    """An importer that a test drives by hand."""

    def __init__(self, path, version, guid):
        super().__init__(path, version, guid)
        self.of, self.now = self._instance(), 0.0

    def start(self, *, whole=None, real=None):
        self.set(whole or {}, real or {})
        self._initialise(self.of)

    def set(self, whole=None, real=None):
        two = self.version == "2"
        if whole:
            self._set("Integer" if two else "Int32", ct.c_int32, self.of, whole)
        if real:
            self._set("Real" if two else "Float64", ct.c_double, self.of, real)

    def advance(self, length):
        self._step(self.of, self.now, length)
        self.now += length

    def read(self, count=1):
        return np.array(self._read(self.of, count))

    def status(self, name, *arguments):
        return self._function(name)(self.of, *arguments)

    def step_status(self, now, length):
        from_s, for_s = ct.c_double(now), ct.c_double(length)
        if self.version == "2":
            return self.status("DoStep", from_s, for_s, ct.c_int(1))
        flags = [ct.byref(ct.c_bool(False)) for _ in range(3)]
        return self.status("DoStep", from_s, for_s, ct.c_bool(True), *flags, ct.byref(ct.c_double(0.0)))


@pytest.fixture(scope="module")
def unit(of_paper, at_rest, tmp_path_factory):
    """Return the paper's units as they fly, written, with the mechanism on a base at rest."""
    folder = tmp_path_factory.mktemp("units")
    paths = {version: folder / f"fmi{version}.fmu" for version in "23"}
    for version, path in paths.items():
        assert of_paper.write(version, path) is None
    return of_paper, at_rest.mechanism, paths


@pytest.fixture
def importer(unit):
    """Return a function that loads a version's unit anew."""
    with ExitStack() as opened_here:

        def load(version, kind=Driven):
            return opened_here.enter_context(kind(unit[2][version], version, unit[0].guid))

        yield load


def kernel(mechanism, command, seconds=SECONDS):
    """Return all outputs of a mechanism under a command, (n, n_y), and its switches."""
    simulator = Simulator(mechanism.plant, command, TimeBase(RATE_HZ, round(seconds * RATE_HZ) + 1))
    done = simulate_run(simulator.run(mechanism.kernel_values(), events=10_000))
    return np.column_stack(list(done.values.values())), done.switching


@pytest.mark.parametrize("version", "23")
def test_the_result_does_not_depend_on_the_communication_step(unit, importer, version):
    """Truth: the kernel to 1e-9 N m, for steps of 1e-5 to 1e-1 s, and for irregular ones drawn at random."""
    truth, _ = kernel(unit[1], SWEEP)
    count, trial = truth.shape[1], Trial("sweep", SWEEP, TimeBase(RATE_HZ, 1))
    rng = np.random.default_rng(4)
    for every in (1000, 100, 10, 1):
        steps = np.full(int(SECONDS * RATE_HZ) // every, every / RATE_HZ)
        found = importer(version, Importer).outputs(trial, steps, count)
        assert np.abs(found[:, 0] - truth[::every, 0]).max() < 1e-9
    fine = importer(version, Importer).outputs(trial, np.full(3000, 1e-5), count)
    assert np.abs(fine[::10, 0] - truth[:301, 0]).max() < 1e-9
    rows = np.unique(np.concatenate([[0], rng.choice(np.arange(1, 10_000), 300, replace=False)]))
    odd = np.concatenate([[step * 0.3, step * 0.7] for step in np.diff(rows) / RATE_HZ])
    found = importer(version, Importer).outputs(trial, odd, count)
    assert np.abs(found[::2, 0] - truth[rows, 0]).max() < 1e-9


@pytest.mark.parametrize("version", "23")
def test_steps_come_by_index_by_rate_and_by_voltage(unit, importer, version):
    """Truth: the kernel under full steps at 40 a second, each way of commanding."""
    command = Command(stepping="full", microsteps=1, rate=RateProfile.constant(40.0))
    truth = kernel(unit[1], command, 0.2)[0][2000, 0]
    by_rate = importer(version)
    by_rate.start(whole={MODE: 2})
    by_rate.set(real={RATE: 40.0})
    by_rate.advance(0.2)
    by_index, by_voltage = importer(version), importer(version)
    by_index.start(whole={MODE: 1})
    by_voltage.start(whole={MODE: 3}, real={VOLTAGE_A: -5.7, VOLTAGE_A + 1: 0.0})
    volts = [(-5.7, 0.0), (0.0, 5.7), (5.7, 0.0), (0.0, -5.7)]
    for k in range(1, 9):
        by_index.advance(0.025 if k < 8 else 0.2 - by_index.now)
        by_voltage.advance(0.025 if k < 8 else 0.2 - by_voltage.now)
        if k < 8:
            by_index.set(whole={INDEX: k})
            by_voltage.set(real=dict(zip((VOLTAGE_A, VOLTAGE_A + 1), volts[k % 4], strict=True)))
    for found in (by_rate, by_index, by_voltage):
        assert found.read()[0] == pytest.approx(truth, abs=1e-9)


@pytest.mark.parametrize("version", "23")
def test_base_and_outside_torque_are_inputs(unit, importer, version):
    """Truth: the kernel of the same mechanism with its ports, both inputs held as edges at the same instants."""
    mechanism = unit[0].handover.mechanism
    names = [s.name for s in mechanism.plant.inputs]
    torque, base = names.index("output_torque"), names.index("base_acceleration")
    made = importer(version)
    made.start()
    values, times = [], []
    for k in range(40):
        level = np.zeros(len(names))
        level[:2] = -1.0, 0.0
        level[torque], level[base] = 0.3 * np.sin(0.7 * k), 2.0 * np.cos(0.4 * k)
        made.set(real={INPUT + torque: level[torque], INPUT + base: level[base]})
        made.advance(0.0025)
        values.append(level)
        times.append(0.0025 * k)
    rest = np.zeros(len(names))
    rest[0] = -1.0
    edges = Excitation(initial=values[0], times=np.array(times[1:]), values=np.array(values[1:]), inputs=tuple(names))
    still = Command(stepping="full", microsteps=1, rate=RateProfile.constant(0.0))
    simulator = Simulator(mechanism.plant, still, TimeBase(RATE_HZ, 1001), known_edges=edges)
    truth = simulate_run(simulator.run(mechanism.kernel_values())).values["torque"][-1]
    assert abs(truth) > 1e-3
    assert made.read()[0] == pytest.approx(truth, abs=1e-9)


@pytest.mark.parametrize("version", "23")
def test_absurd_inputs_are_answered_with_an_error(importer, version):
    """Truth: the standards' status 3, error; then the unit goes on as if nothing had been asked."""
    made = importer(version)
    made.start(whole={MODE: 2}, real={RATE: 46.0})
    made.advance(0.01)
    for now, length in ((0.01, np.nan), (np.nan, 0.01), (0.01, -0.01), (0.005, 0.01), (0.01, 1e3), (0.01, np.inf)):
        assert made.step_status(now, length) == ERROR, (now, length)
    number, value = (ct.c_uint32 * 1)(PARAMETER), (ct.c_double * 1)(np.nan)
    kind, extra = ("SetReal", ()) if version == "2" else ("SetFloat64", (ct.c_size_t(1),))
    assert made.status(kind, number, ct.c_size_t(1), value, *extra) == ERROR
    assert made.status(kind, (ct.c_uint32 * 1)(777_777), ct.c_size_t(1), (ct.c_double * 1)(1.0), *extra) == ERROR
    made.advance(0.01)
    other = importer(version)
    other.start(whole={MODE: 2}, real={RATE: 46.0})
    other.advance(0.02)
    assert made.read()[0] == other.read()[0]


@pytest.mark.parametrize("version", "23")
def test_an_index_that_leaps_is_an_error(importer, version):
    """Truth: status 3 at once, and the unit goes on from the index that it had."""
    made = importer(version)
    made.start(whole={MODE: 1})
    made.set(whole={INDEX: 900_000_000})
    assert made.step_status(0.0, 0.01) == ERROR
    made.set(whole={INDEX: 1})
    made.advance(0.01)
    assert np.isfinite(made.read()[0])


@pytest.mark.parametrize("version", "23")
def test_a_state_is_taken_up_again(importer, version):
    """Truth: the same future twice, also from the bytes of the state in another instance."""
    made, word = importer(version), "FMUstate" if version == "2" else "FMUState"
    made.start(whole={MODE: 2}, real={RATE: 46.0})
    made.advance(0.0501)
    saved = ct.c_void_p(None)
    assert made.status(f"Get{word}", ct.byref(saved)) == 0
    size = ct.c_size_t(0)
    assert made.status(f"Serialized{word}Size", saved, ct.byref(size)) == 0
    raw = ct.create_string_buffer(size.value)
    assert made.status(f"Serialize{word}", saved, raw, size) == 0
    made.advance(0.07)
    first = made.read()[0]
    made.now = 0.0501
    assert made.status(f"Set{word}", saved) == 0
    made.advance(0.07)
    assert made.read()[0] == first
    other, again = importer(version), ct.c_void_p(None)
    other.start()
    name = "DeSerializeFMUstate" if version == "2" else "DeserializeFMUState"
    assert other.status(name, raw, size, ct.byref(again)) == 0
    assert other.status(f"Set{word}", again) == 0
    other.now = 0.0501
    other.advance(0.07)
    assert other.read()[0] == first


def test_events_end_a_step_early_in_fmi_3(unit, importer):
    """Truth: the instants of the steps, and of the kernel's switches, to 1e-9 s."""
    command = Command(stepping="full", microsteps=1, rate=RateProfile.constant(20.0))
    _, switching = kernel(unit[1], command, 0.3)
    made = importer("3", Importer)
    no, yes, nothing = ct.c_bool(False), ct.c_bool(True), ct.c_void_p(None)
    of = ct.c_void_p(
        made._function("InstantiateCoSimulation", ct.c_void_p)(
            b"early", made.guid, b"", no, no, yes, yes, nothing, ct.c_size_t(0), nothing, nothing, nothing
        )
    )
    made._command(of, Trial("full", command, TimeBase(RATE_HZ, 1)))
    made._initialise(of)
    now, instants = 0.0, []
    for _ in range(1000):
        event, end, early, reached = ct.c_bool(False), ct.c_bool(False), ct.c_bool(False), ct.c_double(0.0)
        made._call(
            "DoStep", of, ct.c_double(now), ct.c_double(0.3 - now), yes, *map(ct.byref, (event, end, early, reached))
        )
        now = reached.value
        if not early.value:
            break
        assert event.value
        instants.append(now)
    truth = np.sort(np.concatenate([np.arange(0.05, 0.299, 0.05), switching.time[switching.time > 1e-9]]))
    assert now == pytest.approx(0.3)
    assert len(instants) == len(truth)
    assert np.abs(np.array(instants) - truth).max() < 1e-9


@pytest.mark.skipif(FMPY is None, reason="FMPy is not installed")
@pytest.mark.parametrize("version", "23")
def test_fmpy_has_nothing_to_say(unit, version):
    """Truth: FMPy's validation against the standard's schema and rules."""
    done = subprocess.run([FMPY, "validate", unit[2][version]], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    assert "No problems found" in done.stdout


@pytest.mark.slow
def test_the_bench_variant_has_the_housing(paper, tmp_path):
    """Truth: the kernel of the bench, housing and all; and what is said of it."""
    done = write_export(paper, "fmu", tmp_path, Options(stand=True))
    assert done.written.checked.largest_error < 1e-9
    assert "as on the bench, with [housing]" in done.to_dict()["mechanism"]
    assert {path.name for path in tmp_path.iterdir()} == {*done.written.files, *PAGES, "mechid_export.json"}
    with zipfile.ZipFile(tmp_path / done.written.files[0]) as archive:
        names = archive.namelist()
    assert {"modelDescription.xml", "sources/mechanism.c", "sources/fmi2.c"} <= set(names)
    assert any(name.startswith("binaries/") for name in names)


def test_without_a_compiler_there_are_sources(paper, tmp_path, monkeypatch):
    """Truth: a source unit for other machines; the first line says that it was not compared."""
    monkeypatch.setenv("CC", "no-such-compiler")
    done = write_export(paper, "fmu", tmp_path)
    assert done.written.checked is None
    assert "Without binary, not compared" in done.written.words[0]
    with zipfile.ZipFile(tmp_path / done.written.files[1]) as archive:
        assert "sources/buildDescription.xml" in archive.namelist()
        assert not any(name.startswith("binaries/") for name in archive.namelist())


def test_what_a_unit_cannot_express_is_refused(paper):
    """Truth: a mechanism that measured channels drive; options that there are not."""
    measured = mechanism_of(changed(paper_table(), {"stepper": {"drive": "measured_voltage", "peak_voltage": None}}))
    with pytest.raises(InputFileError, match="follows measured channels"):
        without_ports(replace(paper, mechanism=measured), {}, stand=True)
    with pytest.raises(UsageError, match="write yes or no"):
        Options.read({"stand": "maybe"})
    with pytest.raises(UsageError, match='did you mean "stand"'):
        Options.read({"stnad": "yes"})
    for stand in (True, False):
        with pytest.raises(UsageError, match=r"load.inertia: found -1; write a number from 0"):
            without_ports(paper, {"load.inertia": -1.0}, stand=stand)
        with pytest.raises(UsageError, match=r"load.inertai.*did you mean"):
            without_ports(paper, {"load.inertai": 1.0}, stand=stand)
    assert Options.read({"stand": "yes", "load.inertia": "35"}).values == {"load.inertia": 35.0}


def test_it_needs_no_python(importer):
    """Truth: the libraries that the binary asks for."""
    if not sys.platform.startswith("linux") or not shutil.which("ldd"):
        pytest.skip("there is no ldd")
    needed = subprocess.run(["ldd", importer("2").library._name], capture_output=True, text=True, check=True).stdout
    assert "python" not in needed
    assert "libc.so" in needed
