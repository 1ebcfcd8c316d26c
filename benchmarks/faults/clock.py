"""A clock that is set back by an hour while a run is at work."""

from functools import partial

import numpy as np

from faults.layers import with_layer
from faults.reference import Trial, afterwards, last, numbers, run, unexpected


def stepped(reference, count):
    """Yield the trials."""
    rng = np.random.default_rng([reference.seed, 3])
    for k, share in enumerate(rng.uniform(0.1, 0.9, count or 6)):
        verb = ("identify", "bootstrap", "profile")[k % 3]
        yield Trial(k, f"{verb}, set back at {share:.3f} of its time", partial(_one, reference, verb, float(share)))


def _one(reference, verb, share):
    whole, took = reference.whole(verb)
    out = reference.empty("clock")
    done = run(reference.command(verb, out), **with_layer(f"clock:{share * took}"))
    faults = unexpected(done.stderr)
    if done.returncode not in (0, 5):
        return {"faults": [*faults, f"exit code {done.returncode}: {last(done.stderr)}"]}
    faults += [] if numbers(out, verb) == whole else ["other numbers"]
    return {"faults": faults + afterwards(reference, verb, out)}
