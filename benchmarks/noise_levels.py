"""How the measured examples are followed without a noise level in their campaign.toml, and with one.

Each of `examples/measured/` is identified three times: with the level that is known beforehand declared, which is
never raised; with none declared; and with four times the residual that this leaves declared, as one found by trial
would be. One row of a table for each channel: how far its record is followed, and the RMS of the residual.

    MECHID_DATA=/where/the/data/are python benchmarks/noise_levels.py [NAME ...]
"""

import os
import shutil
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from mechid.campaign import Campaign, CampaignRecord, Match, load_campaign
from mechid.identification.identify import identify
from mechid.identification.output_error.noise_level import known_noise
from mechid.identification.result.fit import Fit
from mechid.identification.result.record_result import ChannelFit

EXAMPLES = Path(__file__).resolve().parents[1] / "examples" / "measured"
BY_TRIAL = 4.0
"""Times the residual: what was found by trial was 2 to 14 times."""
HEAD = "| campaign, channel | known level | followed with it | rests on at the end, and level | followed, outcome | \
residual | by trial | CPU s: known, without, by trial |"
Level = Callable[[CampaignRecord, Match], float | None]


def main() -> None:
    """Identify the examples named, or all, and print a row for each of their channels."""
    print(HEAD)
    print("|" + "---|" * (HEAD.count("|") - 1))
    with tempfile.TemporaryDirectory() as folder:
        for name in sys.argv[1:] or sorted(path.name for path in EXAMPLES.iterdir()):
            for row in rows(name, _campaign(name, Path(folder))):
                print(row, flush=True)


def _campaign(name: str, folder: Path) -> Campaign:
    copied = folder / name
    shutil.copytree(EXAMPLES / name, copied, ignore=shutil.ignore_patterns("data"))
    (copied / "data").symlink_to(Path(os.environ["MECHID_DATA"]).resolve(), target_is_directory=True)
    return load_campaign(copied)


def rows(name: str, campaign: Campaign) -> list[str]:
    """Return the rows of one campaign."""
    known, before = _timed(_declared(campaign, lambda record, match: known_noise(record, _bare(match)).sigma))
    found, now = _timed(_declared(campaign, lambda record, match: None))
    trial, after = _timed(_declared(campaign, lambda record, match: BY_TRIAL * _own(found, record, match).residual_rms))
    spent = ", ".join(f"{seconds:.0f}" for seconds in (before, now, after))
    return [_row(name, r, m, (known, found, trial), spent) for r in campaign.estimated for m in r.estimated]


def _timed(campaign: Campaign) -> tuple[Fit, float]:
    began = time.process_time()
    return identify(campaign, workers=1), time.process_time() - began


def _declared(campaign: Campaign, level: Level) -> Campaign:
    """Return the campaign with a noise level, or none, declared for all that is estimated from."""
    records = tuple(r if r.use == "validate" else _with_levels(r, level) for r in campaign.records)
    return replace(campaign, records=records)


def _with_levels(record: CampaignRecord, level: Level) -> CampaignRecord:
    return replace(
        record, matches=tuple(replace(m, noise_sigma=_declared_as(record, m, level)) for m in record.matches)
    )


def _declared_as(record: CampaignRecord, match: Match, level: Level) -> float | None:
    """Return a level in the numbers of the file."""
    sigma = level(record, match)
    return None if sigma is None else sigma / abs(record.data.channel(match.quantity).scale)


def _bare(match: Match) -> Match:
    return replace(match, noise_sigma=None)


def _own(fit: Fit, record: CampaignRecord, match: Match) -> ChannelFit:
    return fit.records[record.name].channels[match.quantity]


def _row(name: str, record: CampaignRecord, match: Match, fits: tuple[Fit, Fit, Fit], spent: str) -> str:
    known, found, trial = fits
    own, whole = _own(found, record, match), record.data.duration_s
    far = [f"{fit.records[record.name].horizon_s:.3g} of {whole:.3g} s" for fit in (known, found)]
    cells = [
        f"`{name}`, {match.quantity} in {own.unit}",
        f"{own.initial_noise:.2g}",
        far[0],
        f"{own.noise_rests_on}, {own.noise_sigma:.3g}",
        f"{far[1]}, {found.outcome.code}",
        f"{own.residual_rms:.4g}",
        f"{_own(trial, record, match).residual_rms:.4g}, {trial.outcome.code}",
        spent,
    ]
    return "| " + " | ".join(cells) + " |"


if __name__ == "__main__":
    main()
