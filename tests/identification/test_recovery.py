"""Random mechanisms lead from the catalogue to their optimum; the benchmark that counts them is resumable."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def recover(out, *arguments):
    """Run the benchmark's command, and return what it printed."""
    command = [sys.executable, str(ROOT / "benchmarks" / "recovery.py"), "--out", str(out), *arguments]
    paths = os.pathsep.join(filter(None, [str(ROOT / "src"), os.environ.get("PYTHONPATH")]))
    environment = {**os.environ, "PYTHONPATH": paths}
    return subprocess.run(command, capture_output=True, text=True, check=True, env=environment).stdout


@pytest.mark.slow
@pytest.mark.parametrize(
    ("family", "seeds", "variant"),
    [("1", "1:4", "all"), ("1", "5:6", "slow"), ("1", "5:6", "sweep"), ("2", "0:2", "all")],
)
def test_random_mechanisms_are_recovered(tmp_path, family, seeds, variant):
    """Truth: the mechanisms that made the records, and the Cramer-Rao bound of the exact Jacobian at them."""
    without = [] if variant == "all" else ["--without", variant]
    out = tmp_path / "out.jsonl"
    recover(out, "--family", family, "--seeds", seeds, *without)
    lines = [json.loads(line) for line in out.read_text().splitlines()]
    assert len(lines) == int(seeds[-1]) - int(seeds[0])
    for line in lines:
        assert line["success"], line


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "outcome", "told"),
    [
        (113, "converged", "record full_half at 0.237"),
        (158, "converged", "the instant of a stick/slip is known only to"),
        (162, "cliff", "by its derivatives the cost should still fall by"),
    ],
)
def test_a_stick_slip_near_its_threshold_is_said(tmp_path, seed, outcome, told):
    """Truth: mechanisms whose static friction is passed or not within the standard errors, by their own simulation."""
    out = tmp_path / "out.jsonl"
    recover(out, "--seeds", f"{seed}:{seed + 1}")
    (line,) = map(json.loads, out.read_text().splitlines())
    assert line["success"], line
    assert line["outcome"] == outcome
    assert [w for w in line["warnings"] if told in w]


def test_what_is_in_the_file_is_not_run_again(tmp_path):
    """Truth: the file, whose second line a killed run left unfinished; 1 of 1 has the interval 2.5 % to 100 %."""
    line = {"family": 1, "seed": 7, "variant": "all", "success": True, "wall_s": 3.0}
    out = tmp_path / "out.jsonl"
    out.write_text(json.dumps(line) + "\n" + '{"family": 1, "se\n')
    printed = recover(out, "--seeds", "7:8")
    assert "1 of 1 recovered, 100.0%; 95 % interval (Clopper-Pearson) 2.5% to 100.0%" in printed
    assert len(out.read_text().splitlines()) == 2
