"""The next test: what records would tell, which are worth their time, and which rates lose steps.

Internal to mechid but for the names that docs/python.md lists.
"""
