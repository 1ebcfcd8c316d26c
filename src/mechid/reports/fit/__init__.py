"""The report of a fit: its texts and verdict, its tables, then terminal, Markdown, figures, page."""
