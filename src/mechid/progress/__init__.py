"""Display of progress: a line in a notebook, or a live line on a terminal."""
