"""The search from bad starts: multi-start, gated horizons, cliffs, and the trust region that they drive."""
