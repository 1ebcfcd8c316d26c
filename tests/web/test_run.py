"""The explorer from Python. Truth: what HTTP answers, and an address that is taken."""

import asyncio
import signal
import sys
import threading
import urllib.request

import pytest

import mechid
from mechid.campaign.bench import TRUTH

WAIT_S = 120.0


@pytest.fixture(scope="module")
def campaign():
    """Return a campaign in memory, of one short record at the bench's truth."""
    mechanism = mechid.catalogue_mechanism().with_values(TRUTH).with_free(("gear.stiffness",))
    command = mechid.make_command("full", rate=46.0, start_angle_deg=45.0)
    planned = mechid.make_campaign(mechanism, [mechid.make_record("full_46", command=command)])
    run = mechid.simulate(planned, "full_46", sample_rate_hz=10_000.0, duration_s=0.1)
    record = mechid.make_record("full_46", run.torque[:], sample_rate_hz=10_000.0, command=command)
    return mechid.make_campaign(mechanism, [record], name="in_memory")


def answered(pages):
    """Return who fetches the page once it answers, and then presses Ctrl-C."""

    def fetch(address):
        with urllib.request.urlopen(address, timeout=WAIT_S) as answer:
            pages.append(answer.read().decode())
        signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)

    return lambda address: threading.Thread(target=fetch, args=(address,), daemon=True).start()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGINT to send to a thread")
def test_a_campaign_in_memory_is_explored_until_ctrl_c(campaign):
    pages = []
    mechid.explore(campaign, browser=False, say=answered(pages))
    (page,) = pages
    assert "full_46" in page


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGINT to send to a thread")
def test_so_it_is_where_an_event_loop_runs_already_as_in_a_notebook(campaign):
    pages = []

    async def cell():
        mechid.explore(campaign, browser=False, say=answered(pages))

    loop = asyncio.new_event_loop()
    try:
        loop.run_until_complete(cell())
    finally:
        loop.close()
    assert len(pages) == 1


def test_a_port_that_is_taken_is_an_error_there_too(campaign):
    import socket

    async def cell(port):
        mechid.explore(campaign, browser=False, port=port)

    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        loop = asyncio.new_event_loop()
        with pytest.raises(mechid.UsageError, match="port"):
            loop.run_until_complete(cell(taken.getsockname()[1]))
        loop.close()
