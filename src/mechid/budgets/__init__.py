"""Microvibration budget: disturbance, structural coupling, pointing error indices and margins of a mechanism.

Internal to mechid except for the names listed in docs/python.md.
"""
