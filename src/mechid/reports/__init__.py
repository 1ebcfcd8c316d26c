"""The report of a fit: its numbers, its document and figures, and the run that leaves all of it in a folder."""
