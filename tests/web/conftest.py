"""A small campaign in memory, its explorer served from a thread, and a browser."""

import asyncio
import queue
import threading
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import synthetic
from browser import chromium
from diagnosis_folder import DETENT, detent, left, less
from mechid.command import Command, RateProfile
from mechid.web import Explorer, Source, read_diagnosed
from mechid.web.estimate import Estimate
from mechid.web.session import Session
from synthetic import COMMANDS, displaced, measured
from turned import TRUTH

SWEEP = Command(stepping="micro", microsteps=16, rate=RateProfile.through([(0.0, 20.0), (0.8, 100.0)]))
HOSTILE = "<img src=x onerror=document.title='taken'> <script> \"quoted\" 'µ' " + 60 * "long"
"""Would be markup where it is not escaped."""


@pytest.fixture(scope="session")
def campaign():
    """Return two records and a sweep of the demo's mechanism, its gear some percent off, with hostile names around."""
    start = displaced(synthetic.truth(), {"gear.stiffness": 1.05, "gear.damping": 0.9})
    rng = np.random.default_rng(7)
    records = []
    for name, seconds in (("full_46", 0.3), ("micro_46", 0.2), ("sweep", 0.8)):
        command = COMMANDS.get(name, SWEEP)
        torque = measured(synthetic.truth(), command, rng, seconds=seconds)
        record = synthetic.record(name, torque, command, use="validate" if name == "sweep" else "estimate")
        channel = replace(record.data.channels[0], column=HOSTILE)
        data = replace(record.data, channels=(channel,))
        records.append(replace(record, file=Path("/nowhere") / f"{HOSTILE}.csv", data=data))
    made = synthetic.campaign(start, *records)
    return replace(made, path=Path("/nowhere") / HOSTILE / "campaign.toml", warnings=(f"{HOSTILE}: odd",))


@pytest.fixture(scope="session")
def source(campaign):
    return Source(campaign, workers=1)


@pytest.fixture
def session(source):
    """Yield a tab without a browser."""
    made = Session(source)
    yield made
    made.cancel()


@contextmanager
def served(source):
    """Yield the address of an explorer that is served from a thread."""
    said = queue.Queue()

    def serve():
        asyncio.set_event_loop(asyncio.new_event_loop())
        explorer = Explorer(source)
        said.put(explorer)
        explorer.serve(opens_browser=False, ready=said.put)

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()
    explorer, address = said.get(timeout=30), said.get(timeout=30)
    try:
        yield address
    finally:
        loop = explorer.server.io_loop
        loop.add_callback(loop.stop)
        thread.join(30)


@pytest.fixture(scope="session")
def address(source):
    with served(source) as found:
        yield found


@pytest.fixture(scope="session")
def estimated(source, campaign):
    """Yield the address of an explorer that has an estimate, a made up one near the truth, and the estimate."""
    values = {name: q.value for name, q in campaign.parameters.items()} | TRUTH
    sigmas = {"gear.stiffness": 0.021, "gear.damping": 3e-5}
    summary = {"grade": "A", "tone": "good", "headline": "A fit made up.", "questions": []}
    estimate = Estimate(source="made up", values=values, sigmas=sigmas, summary=summary, records=campaign.records)
    with served(replace(source, estimate=estimate)) as found:
        yield found, estimate


@pytest.fixture(scope="session")
def whole():
    """Return the demo's mechanism: stiffness and second detent are to be estimated."""
    return synthetic.truth().with_free(("gear.stiffness", *DETENT))


@pytest.fixture(scope="session")
def diagnosed(campaign, whole, tmp_path_factory):
    """Return an explorer's source whose file lacks the second detent, with the diagnosis that names it."""
    folder = left(tmp_path_factory.mktemp("diagnosis"), whole, detent(whole))
    written = replace(campaign, mechanism=less(whole, "stepper.detent"))
    proposed, said = read_diagnosed(folder, written, None)
    return Source(proposed, workers=1, diagnosed=said)


@pytest.fixture(scope="session")
def lacking(campaign, whole):
    """Return an explorer's source whose file lacks the second detent, and the estimate of a fit that added it."""
    written = replace(campaign, mechanism=less(whole, "stepper.detent"))
    begun = whole.with_values(dict.fromkeys(DETENT, 0.0))
    values = {name: q.value for name, q in replace(campaign, mechanism=whole).parameters.items()}
    summary = {"grade": "B", "tone": "caution", "headline": "A fit made up.", "questions": []}
    estimate = Estimate(
        source="made up", values=values, sigmas={}, summary=summary, records=campaign.records, mechanism=begun
    )
    return Source(written, workers=1), estimate


@pytest.fixture(scope="session")
def following(lacking, tmp_path_factory):
    """Yield the address of an explorer that follows a run elsewhere, and the journal of that run, not begun yet."""
    path = tmp_path_factory.mktemp("elsewhere") / "journal.jsonl"
    with served(replace(lacking[0], journal=path)) as found:
        yield found, path


@pytest.fixture(scope="session")
def switched(diagnosed):
    """Yield the address of an explorer with a switch for the detent that a diagnosis names."""
    with served(diagnosed) as found:
        yield found


@pytest.fixture(scope="module")
def browser():
    with chromium() as opened:
        yield opened
