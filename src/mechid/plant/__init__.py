"""Mechanism models: blocks, their wiring, and the `Plant` and `Mechanism` assembled from them.

Internal to mechid but for the names that docs/python.md lists.
"""
