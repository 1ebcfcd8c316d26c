"""Simulation of a kernel over a record's time base: `Simulator` computes a `Trajectory`.

Internal to mechid but for the names that docs/python.md lists.
"""
