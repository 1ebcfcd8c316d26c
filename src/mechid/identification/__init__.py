"""From a campaign to identified parameters with honest uncertainty: `identify` makes a `Fit`.

Internal to mechid but for the names that docs/python.md lists.
"""
