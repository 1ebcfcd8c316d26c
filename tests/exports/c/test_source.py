"""The C text of a mechanism: what compilers say of it, what it gives beside the kernel, and what it refuses."""

import ctypes
import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest

from fits_by_hand import fit_by_hand
from golden_variants import VARIANTS
from layouts import mechanism_of
from mechid.command import Command, Excitation, RateProfile
from mechid.command.phase_table import nominal_table
from mechid.errors import MechidError, UsageError
from mechid.exports.c.compiler import find_compiler
from mechid.exports.c.source import FILES, Source
from mechid.exports.c.target import Options
from mechid.exports.export import write_export
from mechid.exports.handover import Handover, Trial
from mechid.exports.reference_outputs import ExportedOutput, compare_results, references
from mechid.simulation.simulator import Simulator, TimeBase, simulate_run

STRICT = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-Wconversion", "-O1")
COMPILERS = [name for name in ("gcc", "clang", "clang-14") if shutil.which(name)]
needs_compiler = pytest.mark.skipif(find_compiler() is None, reason="no C compiler is installed")
SWINGING = RateProfile.through(
    [(0.0, 10.0), (0.1, 80.0), (0.2, 80.0), (0.2, -40.0), (0.35, 0.0), (0.4, 0.0), (0.5, 90.0)]
)
FULL = Command(stepping="full", microsteps=1, rate=RateProfile.constant(46.0), start_angle_deg=45.0)
SHAPED = tuple((0.9 * a + 0.1 * b * b * b, 0.95 * b - 0.1 * a * b) for a, b in nominal_table(8).tolist())
SQUARE = Command(stepping="half", microsteps=2, rate=RateProfile.constant(30.0), waveform="square")
TRIALS = (
    Trial("square", SQUARE, TimeBase(1e4, 3001)),
    Trial(
        "swinging", Command(stepping="micro", microsteps=8, rate=SWINGING, start_angle_deg=17.0), TimeBase(1e4, 6001)
    ),
    Trial(
        "by a table",
        Command(stepping="micro", microsteps=8, rate=SWINGING, start_angle_deg=-33.75, table=SHAPED),
        TimeBase(1e4, 3001),
    ),
    Trial("ticking", Command(stepping="micro", microsteps=16, rate=SWINGING, clock_tick_s=3e-4), TimeBase(1e4, 3001)),
)


def source_of(name, *, free=(), sensitive=False):
    """Return the C text of a variant of the golden kernels."""
    mechanism = mechanism_of(VARIANTS[name])
    own = Handover("kept", mechanism, fit_by_hand(mechanism), tuple(free), np.eye(len(free)), ())
    return Source(own, 1e-4, 1, sensitive)


def write(source, folder):
    for name, text in source.files.items():
        (folder / name).write_text(text, encoding="utf-8")


def compile_with(compiler, folder, *flags):
    """Compile the program as strictly as compilers can; their complaint is the failure."""
    sources = [folder / "mechanism.c", folder / "main.c"]
    call = [compiler, *STRICT, *flags, *sources, "-o", folder / "program", "-lm"]
    done = subprocess.run(call, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:2000]
    return folder / "program"


@needs_compiler
def test_it_gives_what_the_kernel_gives(paper, tmp_path):
    """Truth: the kernel, to 1e-9 of the RMS, with the same switches; under jumps, reversals, dwells, ticks, squares."""
    done = write_export(replace(paper, trials=(*paper.trials, *TRIALS)), "c", tmp_path)
    assert sorted(done.written.files) == sorted(FILES)
    found = done.written.checked
    assert found.rms_error < 1e-11
    assert all(trial.name in found.against for trial in TRIALS)
    assert len((tmp_path / "mechanism.c").read_text(encoding="utf-8")) < 200_000


@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("name", ["paper", "direct_torque_drive"])
def test_compilers_have_nothing_to_say(compiler, name, tmp_path):
    """Truth: -std=c99 -pedantic -Wall -Wextra -Wconversion, every word of them an error; with no C library too."""
    write(source_of(name), tmp_path)
    compile_with(compiler, tmp_path)
    compile_with(compiler, tmp_path, "-DMECHANISM_NO_LIBM")


@pytest.mark.slow
@pytest.mark.parametrize("name", VARIANTS)
def test_compilers_have_nothing_to_say_of_any_block(name, tmp_path):
    """Truth: the same of every assembly, law and table."""
    write(source_of(name), tmp_path)
    for compiler in COMPILERS:
        compile_with(compiler, tmp_path)


@pytest.mark.slow
@needs_compiler
def test_sanitizers_and_valgrind_find_nothing(tmp_path):
    """Truth: UBSan and ASan end the program at the first thing they find; valgrind answers with 9."""
    write(source_of("paper"), tmp_path)
    command = tmp_path / "command.csv"
    command.write_text("start_angle_deg,microsteps,square,clock_tick_s\n45,1,0,0\n0,46\n", encoding="utf-8")
    flags = ("-g", "-fsanitize=undefined,address", "-fno-sanitize-recover=all")
    program = compile_with(COMPILERS[-1], tmp_path, *flags)
    done = subprocess.run([program, command, "0.3", tmp_path / "s.csv"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    if shutil.which("valgrind"):
        program = compile_with(COMPILERS[0], tmp_path)
        call = ["valgrind", "-q", "--error-exitcode=9", program, command, "0.05"]
        assert subprocess.run(call, capture_output=True, check=False).returncode == 0


@pytest.mark.slow
@needs_compiler
def test_measured_inputs_are_held(tmp_path):
    """Truth: the kernel of a direct drive under the same held torques."""
    source = source_of("direct_torque_drive")
    write(source, tmp_path)
    times, rng = np.arange(100) * 1e-3, np.random.default_rng(3)
    values = np.column_stack([0.05 * rng.standard_normal((100, 1)), np.zeros((100, len(source.plant.inputs) - 1))])
    rows = "\n".join(",".join(map(repr, row)) for row in np.column_stack([times, values]).tolist())
    (tmp_path / "command.csv").write_text(f"time_s,inputs\n{rows}\n", encoding="utf-8")
    program = compile_with(COMPILERS[0], tmp_path)
    done = subprocess.run([program, tmp_path / "command.csv", "0.1"], capture_output=True, text=True, check=True)
    found = np.array([line.split(",") for line in done.stdout.splitlines()[1:]], dtype=float)[:, 1:]
    mechanism = source.handover.mechanism
    still = Command(stepping="full", microsteps=1, rate=RateProfile.constant(0.0))
    edges = Excitation(np.zeros(values.shape[1]), times[1:], values[1:], tuple(map(str, source.plant.inputs)))
    edges = replace(edges, times=np.concatenate([[1e-12], edges.times]), values=values)
    simulator = Simulator(mechanism.plant, still, TimeBase(1e4, 1001), known_edges=edges)
    truth = np.column_stack(list(simulate_run(simulator.run(mechanism.kernel_values())).values.values()))
    size = np.sqrt(np.mean(truth**2, axis=0))
    assert np.all(np.sqrt(np.mean((found - truth) ** 2, axis=0)) < 1e-6 * size)


ALL = tuple(q.name for q in mechanism_of(VARIANTS["paper"]).free)


@needs_compiler
@pytest.mark.parametrize(
    "free", [ALL, ("gear.stiffness", "gear.damping")], ids=["all", "two whose slopes are constant"]
)
def test_sensitivities_are_the_kernel_s(tmp_path, free):
    """Truth: the kernel's own sensitivities along the same directions, to 1e-9 of each one's RMS."""
    source = source_of("paper", free=free, sensitive=True)
    write(source, tmp_path)
    (tmp_path / "main.c").write_text(SENSITIVE_MAIN, encoding="utf-8")
    program = compile_with(COMPILERS[0], tmp_path)
    done = subprocess.run([program], capture_output=True, text=True, check=True)
    found = np.array([line.split(",") for line in done.stdout.splitlines()], dtype=float)
    mechanism = source.handover.mechanism
    slopes = np.column_stack([mechanism.kernel_jacobian()[name] for name in free])
    simulator = Simulator(mechanism.plant, FULL, TimeBase(1e4, len(found) + 1), capacity=len(free))
    blocks = simulator.run(mechanism.kernel_values(), directions=slopes).blocks()
    truth = np.concatenate([block.jacobian[:, 0, : len(free)].copy() for block in blocks])[1:]
    size = np.sqrt(np.mean(truth**2, axis=0))
    moved = size > 0.0
    assert np.count_nonzero(moved) >= len(free) - 1
    assert np.all(np.sqrt(np.mean((found - truth) ** 2, axis=0))[moved] < 1e-9 * size[moved])


SENSITIVE_MAIN = """\
#include <stdio.h>
#include "mechanism.h"
static mechanism m;
static mechanism_command command = {45.0, 1, 0, 0.0, 1, {0.0}, {46.0}, 0};
int main(void)
{
    int status = mechanism_init(&m) | mechanism_start(&m, &command, 0);
    for (int k = 1; k <= 2000 && status == 0; k++) {
        status = mechanism_advance(&m, k * 1e-4);
        for (int j = 0; j < MECHANISM_FREE; j++) {
            printf(j ? ",%.17g" : "%.17g", m.jacobian[j]);
        }
        printf("\\n");
    }
    return status;
}
"""


class Library:
    """The C text as a library; the structure is opaque but for the outputs behind values and time."""

    def __init__(self, source, folder):
        write(source, folder)
        path = folder / "mechanism.so"
        call = [find_compiler(), "-std=c99", "-O1", "-shared", "-fPIC", folder / "mechanism.c", "-o", path, "-lm"]
        subprocess.run(call, check=True)
        self.of, self.m = ctypes.CDLL(str(path)), ctypes.create_string_buffer(1 << 20)
        self.first = 8 * len(source.plant.declarations)

    def __call__(self, name, *values):
        numbers = [ctypes.c_double(v) if isinstance(v, float) else v for v in values]
        return getattr(self.of, f"mechanism_{name}")(self.m, *numbers)

    @property
    def torque(self):
        return ctypes.c_double.from_buffer(self.m, self.first + 8).value


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """Return the paper's mechanism as a library."""
    if find_compiler() is None:
        pytest.skip("no C compiler is installed")
    return Library(source_of("paper"), tmp_path_factory.mktemp("library"))


def test_looking_changes_nothing(library):
    """Truth: the same instants reached in one stride and in many odd ones, to the last bit."""
    strides = ([0.1, 0.2], [0.00001, 0.0000999, 0.0001, 0.03333, 0.1, 0.11111, 0.2])
    found = []
    for times in strides:
        assert library("init") == 0
        assert library("rate", 46.0) == 0
        for at in times:
            assert library("advance", at) == 0
        found.append(library.torque)
    assert found[0] == found[1] != 0.0


def test_pulses_are_steps(library):
    """Truth: the same steps as a rate brings them, one full step each 25 ms."""
    assert library("init") == 0
    assert library("rate", 40.0) == 0
    assert library("advance", 0.11) == 0
    by_rate = library.torque
    assert library("init") == 0
    for k in range(1, 5):
        assert library("advance", 0.025 * k) == 0
        assert library("pulse", 0.025 * k, 1) == 0
    assert library("advance", 0.11) == 0
    assert library.torque == pytest.approx(by_rate, rel=1e-9)


def test_what_cannot_be_is_refused(library):
    """Truth: mechanism.h: status 3, and time and outputs as they were."""
    assert library("init") == 0
    assert library("advance", 0.01) == 0
    for name, values in (
        ("advance", (float("nan"),)),
        ("advance", (0.005,)),
        ("advance", (float("inf"),)),
        ("rate", (float("nan"),)),
        ("set", (99, 1.0)),
        ("set", (0, float("nan"))),
        ("pulse", (0.001, 1)),
        ("pulse", (0.02, 2)),
    ):
        assert library(name, *values) == 3, (name, values)
    assert library("advance", 0.02) == 0
    assert library("pulse", 0.05, 1) == 0
    assert library("pulse", 0.04, 1) == 3  # before one that is known already
    assert library("advance", 0.06) == 0


def test_a_parameter_may_change_under_way(library):
    """Truth: another stiffness gives another torque; begun anew it is as fitted, to the last bit."""
    assert library("init") == 0
    assert library("rate", 46.0) == 0
    assert library("advance", 0.2) == 0
    as_fitted = library.torque
    names = list(mechanism_of(VARIANTS["paper"]).plant.declarations)
    assert library("init") == 0
    assert library("rate", 46.0) == 0
    assert library("advance", 0.1) == 0
    assert library("set", names.index("gear.stiffness"), 1500.0) == 0
    assert library("advance", 0.2) == 0
    assert library.torque != as_fitted
    assert library("init") == 0
    assert library("rate", 46.0) == 0
    assert library("advance", 0.2) == 0
    assert library.torque == as_fitted


def test_a_wrong_text_is_not_written(paper):
    """Truth: outputs and switches other than the kernel's are refused, whichever it is."""
    (reference, *_) = references(paper)
    own = reference.switching
    switches = np.column_stack([own.time, own.switch, own.before, own.after])
    assert compare_results([reference], [ExportedOutput(reference.outputs, switches)], "it").largest_error == 0.0
    with pytest.raises(MechidError, match="differs by"):
        compare_results([reference], [ExportedOutput(reference.outputs * (1.0 + 1e-6), switches)], "it")
    with pytest.raises(MechidError, match="differs by"):
        compare_results([reference], [ExportedOutput(np.full_like(reference.outputs, np.nan), switches)], "it")
    with pytest.raises(MechidError, match="switches otherwise"):
        compare_results([reference], [ExportedOutput(reference.outputs, switches[:-1])], "it")


def test_without_a_compiler_the_text_is_there_and_says_so(paper, tmp_path, monkeypatch):
    """Truth: DESIGN's contract: checked is null; the first line says why."""
    monkeypatch.setenv("CC", "no-such-compiler")
    done = write_export(paper, "c", tmp_path)
    assert done.written.checked is None
    assert "no C compiler" in done.written.words[0]
    assert (tmp_path / "mechanism.c").is_file()


def test_a_compiler_that_fails_is_said_in_its_own_words(paper, tmp_path, monkeypatch):
    """Truth: the compiler's first error line; the text is kept."""
    compiler = tmp_path / "cc"
    compiler.write_text("#!/bin/sh\necho 'mechanism.c:1: error: no such luck' >&2\nexit 1\n", encoding="utf-8")
    compiler.chmod(0o755)
    monkeypatch.setenv("CC", str(compiler))
    done = write_export(paper, "c", tmp_path / "out")
    assert "no such luck" in done.written.words[0]
    assert (tmp_path / "out" / "main.c").is_file()


def test_options_are_read_or_refused():
    """Truth: the page."""
    assert Options.read({"sensitivities": "yes"}).sensitivities
    with pytest.raises(UsageError, match="did you mean"):
        Options.read({"sensitivity": "yes"})
    with pytest.raises(UsageError, match="yes or no"):
        Options.read({"sensitivities": "1"})
