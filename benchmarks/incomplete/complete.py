"""Complete campaigns, whose model lacks nothing: those of the interval coverage, with two more kinds of noise."""

from dataclasses import replace

import numpy as np

from interval_coverage import POLES, RECORDS, drawn
from mechid.campaign import Campaign, catalogue_mechanism
from mechid.campaign.bench import TRUTH
from recovery.campaigns import RATE_HZ, runs_of, torque_of

HUM, COARSE = "hum", "coarse"
KINDS = ("white", "ar888", "ar46", HUM, COARSE)
HUM_HZ, HUM_NM, RESOLUTION_NM = 50.0, 3e-3, 5e-3
"""Mains hum with a third of it at three times its frequency; a resolution of 2.5 times the noise, not declared."""
OTHER_DRAWS = 10_000
"""From here on count the draws of white noise that hum and resolution are laid over."""


class Complete:
    """Campaigns of the paper's mechanism by kind of noise and draw; its torque is simulated once."""

    def __init__(self) -> None:
        self.mechanism = catalogue_mechanism().with_values(TRUTH)
        self.clean = {name: torque_of(self.mechanism, runs_of(self.mechanism)[name]) for name in RECORDS}

    def campaign(self, kind: str, draw: int) -> Campaign:
        """Return a campaign that nothing is left out of."""
        if kind in POLES:
            return drawn(self.clean, self.mechanism, kind, draw)
        rng = np.random.default_rng((OTHER_DRAWS, KINDS.index(kind), draw))
        white = drawn(self.clean, self.mechanism, "white", OTHER_DRAWS * KINDS.index(kind) + draw)
        return replace(white, records=tuple(_disturbed(record, kind, rng) for record in white.records))


def _disturbed(record, kind: str, rng: np.random.Generator):
    (channel,) = record.data.channels
    y = channel.data
    if kind == HUM:
        turns = 2.0 * np.pi * (HUM_HZ * np.arange(y.size) / RATE_HZ + rng.uniform())
        y = y + HUM_NM * (np.sin(turns) + np.sin(3.0 * turns) / 3.0)
    else:
        y = RESOLUTION_NM * np.round(y / RESOLUTION_NM)
    return replace(record, data=replace(record.data, channels=(replace(channel, data=y),)))
