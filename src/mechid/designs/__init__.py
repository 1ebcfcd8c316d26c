"""Design of the next test: information of records, their selection for a test time, and rates that lose steps.

Internal to mechid except for the names listed in docs/python.md.
"""
