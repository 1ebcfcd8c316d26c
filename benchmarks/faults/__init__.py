"""Scenarios of `faults.py`."""
