"""From a campaign to identified parameters with honest uncertainty: `identify` makes a `Fit`."""
