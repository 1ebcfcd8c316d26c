"""Simulation of records with the mechanism as written, and its presentation."""
