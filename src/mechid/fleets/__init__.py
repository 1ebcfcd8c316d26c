"""Many campaigns, each identified, and what their parameters say together.

Internal to mechid but for the names that docs/python.md lists.
"""
