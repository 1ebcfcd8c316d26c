"""Emission specification: requirements with their masks, and verdicts on values with bounds."""
