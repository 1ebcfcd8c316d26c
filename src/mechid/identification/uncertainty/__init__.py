"""Noise, covariances and standard errors of an estimate, and where they hold only locally."""
