"""Whether the bands of an export's linear models hold what they promise, and what their first order leaves out.

Each model of a result folder is drawn 500 times from its covariance and linearised anew. Over frequencies, inputs and
outputs: the share of draws within two standard errors of the response, 95.4 % where all is linear; and how far the
linear fraction's response is from the draw's own, relative to the largest response of that output to that input.

    python benchmarks/linear_band.py FIT [CAMPAIGN]
"""

import sys
from pathlib import Path

import numpy as np

from mechid.exports.handover import handover
from mechid.exports.linear.fraction import fraction
from mechid.exports.linear.linear import linear_of
from mechid.exports.linear.options import Options
from mechid.exports.linear.state_space import response_of
from mechid.exports.run import read_with_campaign

DRAWS = 500
FREQUENCIES_HZ = np.geomspace(1.0, 400.0, 60)
TOLD = 1e-9
"""Of an input's largest response: a smaller standard error is rounding."""


def main() -> None:
    """Print a row a model."""
    folder, campaign = Path(sys.argv[1]), Path(sys.argv[2]) if len(sys.argv) > 2 else None
    what = handover(*read_with_campaign(folder, campaign)[:2])
    linear = linear_of(what, Options(rates=(), samples=DRAWS))
    print("| model | draws within two sigma: mean | least | most | deltas | fraction off by |")
    print("|---|---|---|---|---|---|")
    for name, model in linear.models.items():
        drawn = np.array([np.abs(response_of(model.samples[k], FREQUENCIES_HZ)) for k in range(DRAWS)])
        shares = 100.0 * within(model, drawn)
        parts = fraction(model)
        print(
            f"| {name} | {shares.mean():.1f} % | {shares.min():.1f} % | {shares.max():.1f} % | {parts.sizes.tolist()} "
            f"| {off(model, parts, drawn):.1g} |"
        )


def within(model, drawn):
    """Return the share of draws in the band at each frequency, output and input that the parameters move, (k,)."""
    here, sigma = np.abs(model.response(FREQUENCIES_HZ)), model.amplitude_sigma(FREQUENCIES_HZ)
    told = sigma > TOLD * here.max(axis=(0, 1), keepdims=True)
    return np.mean(np.abs(drawn - here) <= 2.0 * sigma, axis=0)[told]


def off(model, parts, drawn):
    """Return the largest distance of the fraction's responses from the draws', over each response's largest."""
    here = np.abs(model.response(FREQUENCIES_HZ)).max(axis=0)
    deltas = (model.draws - model.uncertain.values) @ np.linalg.inv(model.uncertain.covariance) @ parts.directions
    size = np.where(here > 0.0, here, 1.0)
    return max(
        float((np.abs(np.abs(response_of(parts.at(d), FREQUENCIES_HZ)) - one) / size).max())
        for d, one in zip(deltas, drawn, strict=True)
    )


if __name__ == "__main__":
    main()
