"""Profiles of the likelihood: their numbers, their document and figures."""
