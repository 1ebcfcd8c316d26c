"""Scores of submissions to the public benchmark; needs NumPy and nothing of mechid."""
