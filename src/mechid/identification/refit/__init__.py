"""Refits around the optimum of a finished fit: profile likelihood and parametric bootstrap."""
