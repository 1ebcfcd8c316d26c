"""All results below a folder: one page that leads to each."""
