"""The report of a diagnosis: its texts and verdict, its tables, then terminal, Markdown, figures, page."""
