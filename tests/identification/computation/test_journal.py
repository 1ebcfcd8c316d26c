"""The journal: what was worked out comes back to the bit, and a run goes on from any line of it."""

import hashlib
import json
import math
import tracemalloc

import numpy as np
import pytest

from mechid.errors import UsageError
from mechid.identification.computation.journal import Journal, last_run, pack, seal, unpack
from mechid.identification.identify import identify
from mechid.identification.output_error.digests import campaign_digests, file_digest
from synthetic import bench, displaced, truth

INPUTS = {"mechanism": "m"}


def lines_of(path):
    return [json.loads(line) for line in path.read_text().splitlines()]


@pytest.mark.parametrize("value", [0.1, -0.0, math.inf, 5e-324, 1.7976931348623157e308, True, 3, "x", None])
def test_a_value_comes_back_to_the_bit(value):
    """Truth: the value itself; the sign of zero counts."""
    found = unpack(json.loads(json.dumps(pack([value, {"a": value}]))))
    assert repr(found) == repr([value, {"a": value}])


def test_an_array_comes_back_to_the_bit():
    """Truth: its bytes, not-a-numbers and shapes without rows included."""
    rng = np.random.default_rng(1)
    for array in (rng.standard_normal((3, 4)), np.array([np.nan, np.inf, -0.0]), np.zeros((1, 0))):
        found = unpack(json.loads(json.dumps(pack(array))))
        assert (found.shape, found.tobytes()) == (array.shape, array.tobytes())


def test_a_known_step_is_not_worked_out_again_and_leaves_its_generator_where_it_was(tmp_path):
    """Truth: the first run's result, and the draw that follows it."""
    path = tmp_path / "journal.jsonl"
    rng = np.random.default_rng(5)
    first = Journal.open(path, INPUTS).step("draw", [1.0], lambda: rng.standard_normal(3), rng)
    then = rng.standard_normal()
    again, fresh = Journal.open(path, INPUTS, resume=True), np.random.default_rng(5)
    second = again.step("draw", [1.0], lambda: pytest.fail("worked out again"), fresh)
    assert second.tobytes() == first.tobytes()
    assert fresh.standard_normal() == then
    assert again.step("draw", [2.0], lambda: 7) == 7


def test_a_half_written_last_line_is_no_line(tmp_path):
    """Truth: the whole lines before it; what comes next begins a line of its own."""
    path = tmp_path / "journal.jsonl"
    journal = Journal.open(path, INPUTS)
    journal.step("a", [1], lambda: 1)
    whole = path.read_text()
    journal.step("b", [2], lambda: 2)
    path.write_text(path.read_text()[: len(whole) + 20])
    resumed = Journal.open(path, INPUTS, resume=True)
    assert len(resumed.known) == 1
    assert [line["event"] for line in lines_of(path)] == ["started", "step", "resumed"]


def test_a_new_run_takes_nothing_from_the_one_before(tmp_path):
    path = tmp_path / "journal.jsonl"
    Journal.open(path, INPUTS).step("a", [1], lambda: 1)
    assert Journal.open(path, INPUTS).step("a", [1], lambda: 2) == 2
    assert Journal.open(path, INPUTS, resume=True).step("a", [1], lambda: 3) == 2


def test_a_journal_of_other_inputs_is_refused(tmp_path):
    path = tmp_path / "journal.jsonl"
    Journal.open(path, {"mechanism": "m", "seed": "1"})
    with pytest.raises(UsageError, match=r"had other inputs \(seed\); .* without --resume"):
        Journal.open(path, {"mechanism": "m", "seed": "2"}, resume=True)


def test_a_file_that_is_no_journal_is_refused(tmp_path):
    path = tmp_path / "journal.jsonl"
    path.write_text("started yesterday\n")
    with pytest.raises(UsageError, match="line 1: is no entry of a journal"):
        Journal.open(path, INPUTS)


@pytest.mark.parametrize("resume", [False, True])
def test_the_journal_of_a_version_without_digests_stays_and_a_run_begins_behind_it(tmp_path, resume):
    """Truth: its lines, to the letter; nothing of them is taken, since nothing says whether they are whole."""
    path = tmp_path / "journal.jsonl"
    earlier = "".join(json.dumps(line) + "\n" for line in ({"event": "started", "inputs": INPUTS}, {"event": "step"}))
    path.write_text(earlier)
    journal = Journal.open(path, INPUTS, resume=resume)
    assert "earlier version" in journal.notice
    assert journal.step("a", [1], lambda: 1) == 1
    assert path.read_text().startswith(earlier)
    assert Journal.open(path, INPUTS, resume=True).step("a", [1], lambda: 2) == 1


FORGED = {
    "a number that is none": {"result": {"hex": "no"}},
    "a number beyond all numbers": {"result": {"hex": "0x1p99999"}},
    "an array of another size": {"result": {"shape": [2], "hex": "0x1p0"}},
    "entries without values": {"result": {"items": [1]}},
    "no value": {"result": {}},
    "the state of another generator": {"rng": {"items": [["bit_generator", "MT19937"]]}},
    "half of a state": {"rng": {"items": [["bit_generator", "PCG64"], ["state", {"items": []}]]}},
    "no state": {"rng": None},
}


@pytest.mark.parametrize("forged", FORGED)
def test_a_line_that_is_whole_and_holds_no_value_is_worked_out_again(tmp_path, forged):
    """Truth: the first run's result; a digest says that a line is as it was written, not who wrote it."""
    path = tmp_path / "journal.jsonl"

    def drawn(journal):
        rng = np.random.default_rng(5)
        return journal.step("draw", [1.0], lambda: rng.standard_normal(3), rng), rng.standard_normal()

    first, then = drawn(Journal.open(path, INPUTS))
    lines = path.read_text().splitlines()
    path.write_text("\n".join([lines[0], seal({**entry(lines[1]), **FORGED[forged]})]) + "\n")
    result, following = drawn(Journal.open(path, INPUTS, resume=True))
    assert (result.tobytes(), following) == (first.tobytes(), then)


def test_what_the_search_sees_has_a_digest_by_name():
    """Truth: of two campaigns that differ in a record's noise, that record's digest alone differs."""
    one, other = (bench(truth(), truth(), "full_46", seed=seed, seconds=0.05) for seed in (1, 2))
    a, b = campaign_digests(one), campaign_digests(other)
    assert {name for name in a if a[name] != b[name]} == {"record full_46"}


@pytest.fixture(scope="module")
def campaign():
    """Return a campaign whose search goes through every kind of step from some way off."""
    factors = {"gear.stiffness": 1.8, "stepper.torque_constant": 0.8, "friction.coulomb": 4.0, "friction.static": 2.0}
    return bench(displaced(truth(), factors), truth(), "full_46", "micro_46", seed=4, seconds=0.3)


def numbers(fit):
    """Return what a fit holds, without how long it took."""
    content = fit.to_dict()
    content["provenance"].pop("wall_time_s")
    for stage in content["stages"]:
        stage.pop("seconds")
    return json.dumps(content)


@pytest.mark.parametrize("every", [5, pytest.param(1, marks=pytest.mark.slow)])
def test_from_every_line_of_its_journal_a_run_comes_to_the_same_numbers(campaign, tmp_path, every):
    """Truth: the undisturbed run; a killed one leaves some whole lines and perhaps the beginning of the next."""
    path = tmp_path / "whole.jsonl"
    undisturbed = numbers(identify(campaign, journal=Journal.open(path, INPUTS)))
    lines = path.read_text().splitlines(keepends=True)
    kinds = [json.loads(line)["step"] for line in lines[1:]]
    assert {"starts", "starts refined", "growth begins", "growth round", "joint fit"} <= set(kinds)
    later = [i for i in range(1, len(lines)) if kinds[i - 1] != "starts"][::every]
    for count in [1, 9, *later]:
        cut = tmp_path / f"{count}.jsonl"
        cut.write_text("".join(lines[:count]) + "".join(lines[count : count + 1])[:30])
        resumed = Journal.open(cut, INPUTS, resume=True)
        assert len(resumed.known) == count - 1
        assert numbers(identify(campaign, journal=resumed)) == undisturbed, count
        done = [line["step"] for line in lines_of(cut) if line["event"] == "step"]
        assert done == kinds, "nothing is worked out twice"


def test_without_a_journal_the_numbers_are_the_same(campaign, tmp_path):
    """Truth: the run without one."""
    kept = identify(campaign, journal=Journal.open(tmp_path / "journal.jsonl", INPUTS))
    assert numbers(kept) == numbers(identify(campaign))


DAMAGES = {
    "a letter changed": lambda line: line.replace('"seconds"', '"secondz"'),
    "without its key": lambda line: seal({k: v for k, v in entry(line).items() if k != "key"}),
    "without its result": lambda line: seal({k: v for k, v in entry(line).items() if k != "result"}),
    "a key that is a number": lambda line: seal({**entry(line), "key": 3}),
    "seconds that are a text": lambda line: seal({**entry(line), "seconds": "long"}),
    "without its digest": lambda line: json.dumps(entry(line)),
    "another result": lambda line: line.replace('"result": 20', '"result": 21'),
    "no JSON": lambda line: line[:-20],
    "an empty line": lambda line: "",
    "a list": lambda line: "[]",
    "a number": lambda line: seal({}).replace("{}", "7"),
}


def entry(line):
    content = json.loads(line)
    del content["check"]
    return content


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_line_is_left_out_and_nothing_else_is_lost(tmp_path, damage):
    """Truth: the other steps come from the journal, the damaged one is worked out again, to the same result."""
    path = tmp_path / "journal.jsonl"
    journal = Journal.open(path, INPUTS)
    for number in range(1, 4):
        journal.step("a", [number], lambda number=number: 10 * number)
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines[:2], DAMAGES[damage](lines[2]), lines[3]]) + "\n")
    resumed = Journal.open(path, INPUTS, resume=True)
    assert resumed.notice == f"{path}: line 3 is damaged and ignored; the results lost there are computed again"
    done = []
    found = [resumed.step("a", [n], lambda n=n: done.append(n) or 10 * n) for n in range(1, 4)]
    assert (found, done) == ([10, 20, 30], [2])
    assert last_run(path)[1].count("step") == 3


def test_a_damaged_beginning_mixes_no_runs(tmp_path):
    """Truth: a step depends on the inputs of its whole run too, so that none of another run is taken."""
    path = tmp_path / "journal.jsonl"
    Journal.open(path, INPUTS).step("a", [1], lambda: 1)
    Journal.open(path, {"mechanism": "another"}).step("a", [1], lambda: 2)
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines[:2], lines[2][:-9], *lines[3:]]) + "\n")
    assert Journal.open(path, INPUTS, resume=True).step("a", [1], lambda: 3) == 1


def test_the_digest_of_a_long_file_holds_none_of_it(tmp_path):
    """Truth: hashlib's of the same bytes. A report of an hour of CSV took 1012 MB for it, of 376."""
    with (tmp_path / "long").open("wb") as file:
        file.truncate(20 * 2**20)
    tracemalloc.start()
    found = file_digest(tmp_path / "long")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert found == hashlib.sha256(bytes(20 * 2**20)).hexdigest()
    assert peak < 2**20
