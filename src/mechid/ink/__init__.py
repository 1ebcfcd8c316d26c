"""Documents of results with their printers, tables, number formats, and figures."""
