"""From an identified mechanism to the line of sight: disturbance, coupling, pointing error indices, margins.

Internal to mechid but for the names that docs/python.md lists.
"""
