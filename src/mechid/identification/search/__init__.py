"""Search from rough starts: multi-start, gated horizons, cliffs, and the trust-region solver that they use."""
