"""Identification of a campaign's parameters with their uncertainty: `identify` returns a `Fit`.

Internal to mechid except for the names listed in docs/python.md.
"""
