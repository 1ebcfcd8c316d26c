"""Index page of all results below a folder."""
