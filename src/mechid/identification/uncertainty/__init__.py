"""Uncertainty of the parameters: visibility, noise, covariances and standard errors, and where these hold."""
