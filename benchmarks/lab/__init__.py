"""Whole lab benches: everything that a bench has at once, declared as a careful engineer would, and nothing tuned."""
