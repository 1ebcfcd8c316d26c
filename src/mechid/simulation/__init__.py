"""Runs a kernel over a record's time base: `Simulator` makes a `Trajectory`.

Internal to mechid but for the names that docs/python.md lists.
"""
