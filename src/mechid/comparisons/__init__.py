"""Fits of the same records compared: their numbers, their document and figures."""
