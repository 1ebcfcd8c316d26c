"""Records predicted by a fit: numbers, tables, document."""
