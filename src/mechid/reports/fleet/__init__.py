"""The report of a fleet: its verdict and texts in one plain dict, then terminal, page and figures."""
