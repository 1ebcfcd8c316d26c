"""Sampled loops of the drive electronics around the linear models: margins, step responses, checks."""
