"""A bootstrap: its numbers, its document and figures."""
