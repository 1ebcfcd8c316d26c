"""Fleets of campaigns: identification of each one, and joint statistics of their parameters.

Internal to mechid except for the names listed in docs/python.md.
"""
