"""The document of a result and its printers, tables, digits, and figures in the colours of a page."""
