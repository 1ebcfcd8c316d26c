"""The functions that `mechid` itself offers, one for each command, and how their results are shown.

Internal but for the names that `mechid` lists (docs/python.md): import them from there.
"""
