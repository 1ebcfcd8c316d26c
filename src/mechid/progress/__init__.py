"""Progress shown to a user: a line in a notebook, a live line on a terminal."""
