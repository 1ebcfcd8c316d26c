"""Benches with one effect that their mechanism file lacks, by a simulator that shares nothing with mechid's kernel."""
